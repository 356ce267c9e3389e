#include "scenario/scenario_loader.h"

#include <algorithm>
#include <cerrno>
#include <fstream>
#include <iterator>
#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <system_error>
#include <utility>

#include "scenario/image_loader.h"
#include "scenario/limits.h"
#include "scenario/names.h"
#include "scenario/scenario_rules.h"
#include "scenario/text.h"
#include "scenario/yaml_reader.h"

namespace metabuffer {
namespace {

using input::Entry;

/// One entry of a renderer's list as the file has it, before images are read.
struct FrameSource {
    Entry entry;
    std::filesystem::path image;
    std::optional<std::filesystem::path> depth;
    RendererFrame frame;
};

struct RendererSource {
    std::string name;
    std::vector<FrameSource> frames;
};

int integer(const Entry& entry, const IntegerRange& allowed) {
    return static_cast<int>(entry.integer(allowed));
}

void read_optional(const Entry& entry, const IntegerRange& allowed, int& value) {
    if (entry.present()) value = integer(entry, allowed);
}

void read_optional(const Entry& entry, const NumberRange& allowed, double& value) {
    if (entry.present()) value = entry.number(allowed);
}

template <typename Enum>
void read_optional(const Entry& entry, Enum& value) {
    if (entry.present()) value = entry.choice<Enum>();
}

void read_displays(const Entry& entry, DisplayConfig& displays) {
    if (!entry.present()) entry.fail("is missing; use a map with at least the keys width and height");
    read_optional(entry.child("columns"), limits::kGridDisplays, displays.columns);
    read_optional(entry.child("rows"), limits::kGridDisplays, displays.rows);
    displays.width_pixels = integer(entry.child("width"), limits::kDisplayPixels);
    displays.height_pixels = integer(entry.child("height"), limits::kDisplayPixels);
    if (const Entry supersample = entry.child("supersample"); supersample.present()) {
        displays.supersample = supersample.one_of(limits::kSupersamples, "a supersampling");
    }
    if (const Entry background = entry.child("background"); background.present()) {
        const std::vector<Entry> channels = background.items();
        if (channels.size() != std::size(displays.background)) {
            background.fail("has " + std::to_string(channels.size()) +
                            " entries; use three whole numbers 0 to 255, [R, G, B]");
        }
        std::transform(channels.begin(), channels.end(), std::begin(displays.background),
                       [](const Entry& channel) {
                           return static_cast<std::uint8_t>(channel.integer(limits::kChannel));
                       });
    }
}

void read_depth_range(const Entry& entry, Scenario& scenario) {
    if (!entry.present()) return;
    const std::vector<Entry> ends = entry.items();
    if (ends.size() != 2) {
        entry.fail("has " + std::to_string(ends.size()) + " entries; use two numbers, [near, far]");
    }
    scenario.depth_near = ends[0].number(limits::kDepth);
    scenario.depth_far = ends[1].number(limits::kDepth);
}

void read_machine(const Entry& root, Scenario& scenario) {
    const Entry clocks = root.child("clocks");
    read_optional(clocks.child("core_mhz"), limits::kClockMhz, scenario.clocks.core_mhz);
    read_optional(clocks.child("dvi_in_mhz"), limits::kClockMhz, scenario.clocks.dvi_in_mhz);
    read_optional(clocks.child("dvi_out_mhz"), limits::kClockMhz, scenario.clocks.dvi_out_mhz);

    const Entry memory = root.child("memory");
    read_optional(memory.child("page_words"), limits::kPageWords, scenario.memory.page_words);
    read_optional(memory.child("page_miss_cycles"), limits::kPageMissCycles,
                  scenario.memory.page_miss_cycles);
    read_optional(memory.child("words_per_cycle"), limits::kWordsPerCycle, scenario.memory.words_per_cycle);

    const Entry bus = root.child("bus");
    if (const Entry width = bus.child("width_bits"); width.present()) {
        scenario.bus.width_bits = width.one_of(limits::kBusWidthsBits, "a bus width");
    }
    read_optional(bus.child("burst_pixels"), limits::kBurstPixels, scenario.bus.burst_pixels);
    read_optional(bus.child("arbitration"), scenario.bus.arbitration);

    const Entry composer = root.child("composer");
    read_optional(composer.child("buffer_pixels"), limits::kBufferPixels, scenario.composer.buffer_pixels);
    scenario.composer.ready_space_pixels =
        std::max(scenario.bus.burst_pixels, in_flight_pixels(scenario.bus, scenario.memory));
    read_optional(composer.child("ready_space_pixels"), limits::kReadySpacePixels,
                  scenario.composer.ready_space_pixels);
    read_optional(composer.child("on_starvation"), scenario.composer.on_starvation);

    read_optional(root.child("pacing"), scenario.pacing);
    read_optional(root.child("link_timeout_pairs"), limits::kLinkTimeoutPairs, scenario.link_timeout_pairs);
    if (const Entry watchdog = root.child("watchdog_cycles"); watchdog.present()) {
        scenario.watchdog_cycles = watchdog.integer(limits::kWatchdogCycles);
    }
}

ViewportRow read_row(const Entry& entry) {
    const std::vector<Entry> fields = entry.items();
    if (fields.size() != 8) {
        entry.fail("has " + std::to_string(fields.size()) +
                   " entries; use eight, [Dcomp, Sx, Sy, Sdx, Sdy, Dx, Dy, Dmultiple]");
    }
    const auto unsigned_field = [&fields](std::size_t index) {
        return static_cast<std::uint16_t>(fields[index].integer(limits::kUnsignedField));
    };
    const auto signed_field = [&fields](std::size_t index) {
        return static_cast<std::int16_t>(fields[index].integer(limits::kSignedField));
    };
    return {unsigned_field(0), unsigned_field(1), unsigned_field(2), unsigned_field(3),
            unsigned_field(4), signed_field(5),   signed_field(6),   unsigned_field(7)};
}

FrameSource read_frame(const Entry& entry, const std::filesystem::path& base) {
    FrameSource source{entry, base / entry.child("image").name(), std::nullopt, {}};
    if (const Entry depth = entry.child("depth"); depth.present()) source.depth = base / depth.name();

    const Entry viewport = entry.child("viewport");
    const Entry table = entry.child("table");
    if (viewport.present() && table.present()) {
        table.fail("stands beside a viewport; use one of the two");
    }
    if (!viewport.present() && !table.present()) {
        entry.fail("has neither a viewport nor a table; use one of the two");
    }
    if (viewport.present()) {
        Viewport& position = source.frame.viewport.emplace();
        position.x = integer(viewport.child("x"), limits::kViewportPosition);
        position.y = integer(viewport.child("y"), limits::kViewportPosition);
        read_optional(viewport.child("multiple"), limits::kViewportMultiple, position.multiple);
        source.frame.table_line = viewport.place().line;
    } else {
        for (const Entry& row : table.items()) source.frame.table.push_back(read_row(row));
        source.frame.table_line = table.place().line;
    }
    return source;
}

std::vector<RendererSource> read_renderers(const Entry& entry, const std::filesystem::path& base) {
    if (!entry.present()) entry.fail("is missing; use a list of at least one renderer");
    std::vector<RendererSource> renderers;
    for (const Entry& item : entry.items()) {
        RendererSource renderer;
        const Entry name = item.child("name");
        renderer.name = name.present() ? name.name() : "renderer_" + std::to_string(renderers.size() + 1);
        const Entry frames = item.child("frames");
        if (!frames.present()) frames.fail("is missing; use a list of at least one frame");
        for (const Entry& frame : frames.items()) renderer.frames.push_back(read_frame(frame, base));
        renderers.push_back(std::move(renderer));
    }
    return renderers;
}

Fault read_fault(const Entry& entry, const std::vector<std::string>& names) {
    Fault fault;
    const Entry renderer = entry.child("renderer");
    const std::string name = renderer.name();
    const auto found = std::find(names.begin(), names.end(), name);
    if (found == names.end()) {
        renderer.fail(text::quoted(name) + " is not a renderer" +
                      (names.empty() ? std::string("; there is none")
                                     : "; the nearest is " + text::nearest(name, names)));
    }
    fault.renderer = static_cast<int>(found - names.begin());
    fault.pair = static_cast<std::uint32_t>(entry.child("pair").integer(limits::kFaultPair));
    fault.kind = entry.child("kind").choice<FaultKind>();
    read_optional(entry.child("frame"), fault.frame);
    const Entry delay = entry.child("delay_pairs");
    if (fault.kind == FaultKind::kDelay) {
        fault.delay_pairs = integer(delay, limits::kDelayPairs);
    } else if (delay.present()) {
        delay.fail(std::string("does not go with kind ") + to_string(fault.kind) +
                   "; use it with kind delay only");
    }
    return fault;
}

std::vector<Fault> read_faults(const Entry& entry, const std::vector<RendererSource>& renderers) {
    std::vector<std::string> names;
    names.reserve(renderers.size());
    for (const RendererSource& renderer : renderers) names.push_back(renderer.name);
    std::vector<Fault> faults;
    for (const Entry& fault : entry.items()) faults.push_back(read_fault(fault, names));
    return faults;
}

/// The scenario's images by their files, each read once however many renderers name it.
class ImageShelf {
  public:
    explicit ImageShelf(const Scenario& scenario)
        : format_(scenario.depth_format), range_{scenario.depth_near, scenario.depth_far} {}

    const std::shared_ptr<const PixelImage>& image_of(const FrameSource& source) {
        const auto [known, is_new] = images_.try_emplace({source.image, source.depth});
        if (is_new) known->second = std::make_shared<const PixelImage>(load(source));
        return known->second;
    }

  private:
    PixelImage load(const FrameSource& source) const {
        try {
            return load_image(source.image, source.depth, format_, range_);
        } catch (const InputError& error) {
            // The message starts with the file's name, which tells the two keys apart.
            const std::string message = error.what();
            const bool is_depth = source.depth.has_value() && source.depth != source.image &&
                                  message.rfind(text::one_line(source.depth->string()) + ": ", 0) == 0;
            source.entry.child(is_depth ? "depth" : "image").fail(message);
        }
    }

    DepthFormat format_;
    DepthRange range_;
    std::map<std::pair<std::filesystem::path, std::optional<std::filesystem::path>>,
             std::shared_ptr<const PixelImage>>
        images_;
};

void split_viewport_of(RendererFrame& frame, const Entry& entry, const Renderer& renderer,
                       const DisplayWall& wall) {
    if (!frame.viewport.has_value()) return;
    try {
        frame.table =
            split_viewport(*frame.viewport, renderer.image_width_pixels, renderer.image_height_pixels, wall);
    } catch (const std::invalid_argument& error) {
        entry.child("viewport").fail(error.what());
    }
}

void read_images(std::vector<RendererSource>& sources, Scenario& scenario) {
    ImageShelf shelf(scenario);
    for (std::size_t i = 0; i < sources.size(); ++i) {
        Renderer& renderer = scenario.renderers[i];
        std::map<const PixelImage*, std::size_t> indices;  // into the renderer's own list
        for (std::size_t j = 0; j < sources[i].frames.size(); ++j) {
            const FrameSource& source = sources[i].frames[j];
            RendererFrame& frame = renderer.frames[j];
            const std::shared_ptr<const PixelImage>& image = shelf.image_of(source);
            const auto [known, is_new] = indices.try_emplace(image.get(), renderer.images.size());
            if (is_new) renderer.images.push_back(image);
            frame.image = known->second;
            const PixelImage& first = *renderer.images.front();
            renderer.image_width_pixels = first.width_pixels;
            renderer.image_height_pixels = first.height_pixels;
            split_viewport_of(frame, source.entry, renderer, scenario.displays.wall());
        }
    }
}

/// Turns a broken rule into an error with the line of what broke it.
void throw_if(const std::optional<RuleViolation>& violation, const input::Value& root) {
    if (!violation.has_value()) return;
    throw InputError(text::one_line(input::find_place(root, violation->path).describe() + ": " +
                                    violation->path + ": " + violation->message));
}

Scenario read_scenario(const input::Value& tree, const std::string& default_name,
                       const std::filesystem::path& base) {
    input::check_structure(tree);
    const Entry root(tree);
    Scenario scenario;
    const Entry name = root.child("name");
    scenario.name = name.present() ? name.name() : default_name;
    read_displays(root.child("displays"), scenario.displays);
    read_optional(root.child("composition"), scenario.composition);
    read_optional(root.child("depth_format"), scenario.depth_format);
    read_depth_range(root.child("depth_range"), scenario);
    read_machine(root, scenario);

    std::vector<RendererSource> sources = read_renderers(root.child("renderers"), base);
    scenario.faults = read_faults(root.child("faults"), sources);
    std::size_t longest = 1;
    for (const RendererSource& source : sources) {
        longest = std::max(longest, source.frames.size());
        Renderer& renderer = scenario.renderers.emplace_back();
        renderer.name = source.name;
        for (const FrameSource& frame : source.frames) renderer.frames.push_back(frame.frame);
    }
    scenario.frames = static_cast<int>(std::min<std::size_t>(longest, limits::kFrames.high));
    read_optional(root.child("frames"), limits::kFrames, scenario.frames);

    // Reading images takes longest: everything else is checked first.
    throw_if(settings_violation(scenario), tree);
    read_images(sources, scenario);
    throw_if(renderers_violation(scenario), tree);
    return scenario;
}

std::string text_of_file(const std::filesystem::path& file) {
    const auto fail = [&file](int error) {
        throw InputError(
            text::one_line(file.string() + ": cannot be read: " + std::generic_category().message(error)));
    };
    std::error_code error;
    if (std::filesystem::is_directory(file, error)) fail(EISDIR);
    errno = 0;
    std::ifstream stream(file, std::ios::binary);
    if (!stream) fail(errno == 0 ? EIO : errno);
    std::string content{std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>()};
    if (stream.bad()) fail(errno == 0 ? EIO : errno);
    return content;
}

}  // namespace

ScenarioOverride parse_override(const std::string& text) {
    const std::size_t equals = text.find('=');
    if (equals == std::string::npos) {
        throw InputError(text::one_line(
            "--set " + text + ": has no value; use --set PATH=VALUE, like --set bus.width_bits=32"));
    }
    if (equals == 0) {
        throw InputError(text::one_line(
            "--set " + text + ": has no key path; use --set PATH=VALUE, like --set bus.width_bits=32"));
    }
    return {text.substr(0, equals), text.substr(equals + 1)};
}

Scenario parse_scenario(const std::string& text, const std::string& origin, const std::filesystem::path& base,
                        const std::vector<ScenarioOverride>& overrides) {
    input::Value root = input::parse_yaml(text, std::make_shared<const std::string>(origin), true);
    for (const ScenarioOverride& override_ : overrides) input::apply_override(root, override_);
    const std::string stem = text::one_line(std::filesystem::path(origin).stem().string());
    return read_scenario(root, stem.empty() ? "scenario" : stem, base);
}

Scenario load_scenario(const std::filesystem::path& file, const std::vector<ScenarioOverride>& overrides) {
    return parse_scenario(text_of_file(file), file.string(), file.parent_path(), overrides);
}

}  // namespace metabuffer
