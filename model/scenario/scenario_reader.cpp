#include "scenario/scenario_reader.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <optional>
#include <stdexcept>
#include <tuple>
#include <utility>
#include <vector>

#include "host/errors.h"
#include "host/text.h"
#include "scenario/entry.h"
#include "scenario/fault_keys.h"
#include "scenario/fault_kinds.h"
#include "scenario/frame_pattern.h"
#include "scenario/limits.h"
#include "scenario/names.h"
#include "scenario/scenario_keys.h"
#include "scenario/scenario_rules.h"

namespace metabuffer::input {
namespace {

/// A frame as the file has it, before images are read.
struct FrameSource {
    Entry entry;  ///< of the renderer's list; the same for many frames if it has a range
    ImageFiles files;
    RendererFrame frame;
    std::size_t index = 0;        ///< of the entry
    std::optional<int> number{};  ///< in the entry's range
};

struct RendererSource {
    Entry entry;
    std::string name;
    int copies = 1;
    std::vector<FrameSource> frames;  ///< none of a live renderer
    ImageSize live{};                 ///< of a live renderer
    std::size_t first = 0;            ///< of its renderers
};

/// The scenario without its images, and where to find those.
struct Draft {
    Scenario scenario;
    std::vector<RendererSource> sources;
};

/// Reads the keys that are given, and derives values for others.
template <typename Object>
void read_keys(const Entry& base, const std::vector<ObjectKey<Object>>& keys, std::size_t prefix_length,
               Object& object) {
    for (const ObjectKey<Object>& key : keys) {
        if (key.set == nullptr) continue;
        const Entry entry = base.at(key.schema.pattern + prefix_length);
        if (entry.present() || key.required) {
            key.set(object, entry.value());
        } else if (key.derived != nullptr) {
            key.set(object, key.derived(object));
        }
    }
}

constexpr std::string_view kViewportPattern = "renderers[].frames[].viewport.";
constexpr std::string_view kCorrectionPattern = "displays.correction[].";
constexpr std::string_view kPathPattern = "renderers[].frames[].viewport.path[].";

/// A number, or what YAML writes as .nan and .inf, with or without the dot, and Python's JSON as NaN and Infinity.
double any_number(const Entry& entry) {
    using Limits = std::numeric_limits<double>;
    std::string word = entry.name();
    for (char& character : word) {
        if (character >= 'A' && character <= 'Z') character = static_cast<char>(character - 'A' + 'a');
    }
    const bool has_sign = word.front() == '-' || word.front() == '+';
    const double sign = word.front() == '-' ? -1.0 : 1.0;
    word.erase(0, has_sign ? 1 : 0);
    if (word == ".inf" || word == "inf" || word == "infinity") return sign * Limits::infinity();
    if (word == ".nan" || word == "nan") return Limits::quiet_NaN();
    return entry.number({Limits::lowest(), Limits::max()});
}

void read_depth_nothing(const Entry& list, ImageReading& reading) {
    for (const Entry& item : list.items()) {
        const double sample = any_number(item);
        if (std::isnan(sample)) {
            reading.nan_is_nothing = true;
        } else {
            reading.nothing.push_back(sample);
        }
    }
}

Entry correction_of(const Entry& root) { return root.child("displays").child("correction"); }

/// Tables of files are read later, with the images.
std::vector<DisplayCorrection> read_corrections(const Entry& list, const std::filesystem::path& base) {
    std::vector<DisplayCorrection> corrections;
    for (const Entry& item : list.items()) {
        DisplayCorrection& correction = corrections.emplace_back();
        read_keys(item, correction_rows(), kCorrectionPattern.size(), correction);
        const Entry lut = item.child("lut");
        if (lut.present()) correction.lut_file = base / lut.name();
        bool is_given = lut.present();
        for (const char* key : {"gain", "gamma"}) {
            const Entry by_formula = item.child(key);
            if (by_formula.present() && lut.present()) {
                by_formula.fail("is given together with a lut; use one of the two");
            }
            is_given = is_given || by_formula.present();
        }
        if (!is_given) item.fail("has none of gain, gamma and lut; use gain and gamma, or lut");
    }
    return corrections;
}

ViewportRow read_row(const Entry& entry) {
    const std::vector<Entry> entries = entry.items();
    if (entries.size() != table_fields().size()) {
        entry.fail("has " + std::to_string(entries.size()) +
                   " entries; use eight, [Dcomp, Sx, Sy, Sdx, Sdy, Dx, Dy, Dmultiple]");
    }
    ViewportRow row;
    for (std::size_t i = 0; i < entries.size(); ++i) {
        const TableField& field = table_fields()[i];
        field.set(row, entries[i].integer(field.range));
    }
    return row;
}

/// The positions of a moving viewport; none if it stands still.
std::vector<PathPosition> read_path(const Entry& viewport) {
    std::vector<PathPosition> path;
    const Entry entry = viewport.child("path");
    if (!entry.present()) return path;
    for (const ObjectKey<Viewport>& key : viewport_rows()) {
        const std::string name = std::string(key.schema.pattern).substr(kViewportPattern.size());
        if (const Entry still = viewport.child(name); still.present()) {
            still.fail("is given together with a path, which has its own; use one of the two");
        }
    }
    for (const Entry& item : entry.items()) {
        PathPosition position;
        if (!path.empty()) position.viewport.multiple = path.back().viewport.multiple;
        read_keys(item, path_rows(), kPathPattern.size(), position);
        if (!path.empty() && position.frame <= path.back().frame) {
            item.child("frame").fail(std::to_string(position.frame) + " does not come after " +
                                     std::to_string(path.back().frame) + "; use a later frame");
        }
        path.push_back(position);
    }
    if (path.empty()) entry.fail("has no positions; use at least one");
    return path;
}

/// The file of a frame's number.
std::filesystem::path numbered_file(const Entry& entry, const std::filesystem::path& base, int number) {
    const std::optional<std::string> name = numbered_name(entry.name(), number);
    if (!name) {
        entry.fail(text::quoted(entry.name()) +
                   " has a % that is no number's; use one %d, or %04d for four digits");
    }
    return base / *name;
}

/// The depths that images may have. An empty range is not refused here: the rules do so later.
NumberRange depths_of(const ImageReading& reading) {
    using Limits = std::numeric_limits<double>;
    return reading.near != reading.far ? NumberRange{reading.nearest(), reading.farthest()}
                                       : NumberRange{Limits::lowest(), Limits::max()};
}

/// depths: the range of z in a frame that has no range of its own.
FrameSource read_frame(const Entry& entry, const std::filesystem::path& base, NumberRange depths) {
    FrameSource source{entry, {base / entry.child("image").name()}, {}};
    const Entry depth = entry.child("depth");
    if (depth.present()) source.files.depth = base / depth.name();
    if (const Entry layer = entry.child("layer"); layer.present()) source.files.layer = layer.name();
    const Entry depth_layer = entry.child("depth_layer");
    if (depth_layer.present()) source.files.depth_layer = depth_layer.name();
    if (const Entry range = entry.child("depth_range"); range.present()) {
        const auto ends = std::get<std::vector<double>>(range.value());
        source.files.depth_range = {ends[0], ends[1]};
        if (ends[0] == ends[1]) range.fail(same_depths(ends[0]));
        depths = depths_of({ends[0], ends[1]});
    }
    if (const Entry z = entry.child("z"); z.present()) {
        if (depth.present()) z.fail("is given together with a depth; use one of the two");
        if (depth_layer.present()) z.fail("is given together with a depth_layer; use one of the two");
        source.files.z = z.number(depths);
    }

    const Entry viewport = entry.child("viewport");
    const Entry table = entry.child("table");
    const Entry controls = entry.child("controls");
    if (viewport.present() && table.present()) {
        table.fail("is given together with a viewport; use one of the two");
    }
    if (controls.present()) {
        for (const char* const key : {"viewport", "table", "slots"}) {
            if (!entry.child(key).present()) continue;
            controls.fail(std::string("is given together with a ") + key + "; use one of the two");
        }
    } else if (!viewport.present() && !table.present()) {
        entry.fail("has neither a viewport nor a table; use one of the two");
    }
    if (controls.present()) {
        source.frame.table_line = controls.location().line;
    } else if (viewport.present()) {
        source.frame.viewport.emplace();
        if (!viewport.child("path").present()) {
            read_keys(viewport, viewport_rows(), kViewportPattern.size(), *source.frame.viewport);
        }
        source.frame.table_line = viewport.location().line;
    } else {
        for (const Entry& row : table.items()) source.frame.table.push_back(read_row(row));
        source.frame.table_line = table.location().line;
    }
    if (const Entry slots = entry.child("slots"); slots.present()) {
        source.frame.slots.emplace();
        for (const Entry& slot : slots.items()) {
            source.frame.slots->push_back(static_cast<int>(slot.integer(limits::kUnsignedField)));
        }
    }
    return source;
}

/// All frames that an entry of a renderer's list stands for. numbered_frames: the number of those of earlier ranges.
std::vector<FrameSource> read_frames(const Entry& entry, const std::filesystem::path& base,
                                     const NumberRange& depths, std::int64_t& numbered_frames) {
    const FrameSource source = read_frame(entry, base, depths);
    const Entry viewport = entry.child("viewport");
    const std::vector<PathPosition> path =
        viewport.present() ? read_path(viewport) : std::vector<PathPosition>();
    const Entry range = entry.child("frames");
    if (!range.present()) {
        if (!path.empty()) {
            viewport.child("path").fail(
                "goes with a range of frames; add frames, such as 0-29, next to the image");
        }
        return {source};
    }
    const std::optional<FrameNumbers> numbers = parse_frame_numbers(range.name());
    if (!numbers) range.fail(text::quoted(range.name()) + " is not a range; use numbers such as 0-299");
    numbered_frames += numbers->count();
    if (numbered_frames > limits::kNumberedFrames) {
        range.fail("makes " + std::to_string(numbered_frames) + " frames so far; use at most " +
                   std::to_string(limits::kNumberedFrames));
    }
    if (!path.empty() && (path.front().frame < numbers->first || path.back().frame > numbers->last)) {
        viewport.child("path").fail("goes from frame " + std::to_string(path.front().frame) + " to " +
                                    std::to_string(path.back().frame) + "; use frames of " + range.name());
    }
    std::vector<FrameSource> frames;
    for (int number = numbers->first; number <= numbers->last; ++number) {
        FrameSource& frame = frames.emplace_back(source);
        frame.number = number;
        frame.files.image = numbered_file(entry.child("image"), base, number);
        if (frame.files.depth) frame.files.depth = numbered_file(entry.child("depth"), base, number);
        if (!path.empty()) frame.frame.viewport = viewport_on_path(path, number);
    }
    return frames;
}

std::vector<RendererSource> read_renderers(const Entry& entry, const std::filesystem::path& base,
                                           const NumberRange& depths) {
    if (!entry.present()) entry.fail("is missing; use a list of at least one renderer");
    std::vector<RendererSource> renderers;
    std::int64_t numbered_frames = 0;
    for (const Entry& item : entry.items()) {
        RendererSource renderer{item, "renderer_" + std::to_string(renderers.size() + 1), 1, {}, {}, 0};
        if (const Entry name = item.child("name"); name.present()) renderer.name = name.name();
        if (const Entry copies = item.child("copies"); copies.present()) renderer.copies = copies.integer();
        const Entry frames = item.child("frames");
        if (const Entry live = item.child("live"); live.present()) {
            const Entry width = live.child("width");
            const Entry height = live.child("height");
            // What is given is judged before what is missing.
            renderer.live = {width.present() ? width.integer() : 0, height.present() ? height.integer() : 0};
            if (frames.present()) live.fail("is given together with frames; use one of the two");
            renderer.live = {width.integer(), height.integer()};
        } else if (!frames.present()) {
            frames.fail("is missing; use a list of at least one frame");
        }
        std::size_t index = 0;
        for (const Entry& frame : frames.items()) {
            for (FrameSource& source : read_frames(frame, base, depths, numbered_frames)) {
                source.index = index;
                renderer.frames.push_back(std::move(source));
            }
            ++index;
        }
        renderers.push_back(std::move(renderer));
    }
    return renderers;
}

/// Makes the scenario's renderers, copies written out, without images.
void make_renderers(Draft& draft) {
    std::int64_t copied_frames = 0;
    for (RendererSource& source : draft.sources) {
        std::vector<Renderer>& renderers = draft.scenario.renderers;
        source.first = renderers.size();
        if (source.copies > 1) {
            copied_frames += std::int64_t{source.copies} * static_cast<std::int64_t>(source.frames.size());
            const auto total = static_cast<std::int64_t>(renderers.size()) + source.copies;
            if (total > limits::kComposers || copied_frames > limits::kCopiedFrames) {
                source.entry.child("copies").fail(
                    "makes " + std::to_string(total) + " renderers and " + std::to_string(copied_frames) +
                    " frames so far; use at most " + std::to_string(limits::kComposers) + " and " +
                    std::to_string(limits::kCopiedFrames));
            }
        }
        Renderer renderer;
        for (const FrameSource& frame : source.frames) renderer.frames.push_back(frame.frame);
        renderer.is_live = source.live.width_pixels > 0;
        if (renderer.is_live) renderer.frames.emplace_back();  // until the application's first
        for (int copy = 1; copy <= source.copies; ++copy) {
            renderer.name = source.copies == 1 ? source.name : source.name + "_" + std::to_string(copy);
            renderers.push_back(renderer);
        }
    }
}

int renderer_index(const Entry& renderer, const std::vector<std::string>& names) {
    const std::string name = renderer.name();
    const auto found = std::find(names.begin(), names.end(), name);
    if (found == names.end()) {
        renderer.fail(text::quoted(name) + " is not a renderer" +
                      (names.empty() ? std::string("; there is none")
                                     : "; the nearest is " + text::nearest(name, names)));
    }
    return static_cast<int>(found - names.begin());
}

Fault read_fault(const Entry& entry, const std::vector<std::string>& names) {
    Fault fault;
    fault.where = entry.where();
    const Entry renderer = entry.child("renderer");
    fault.kind = entry.child("kind").choice<FaultKind>();
    if (fault_traits(fault.kind).names_renderer()) {
        fault.renderer = renderer_index(renderer, names);
    } else if (renderer.present()) {
        renderer.fail(std::string("does not go with kind ") + to_string(fault.kind) +
                      ", which is the whole machine's; leave it out");
    }
    for (const FaultKey& key : fault_keys()) {
        const Entry value = entry.child(key.name());
        const FaultKeyUse* const use = use_of(key, fault.kind);
        if (use == nullptr) {
            if (value.present()) value.fail(misplaced_fault_key(key, fault.kind));
        } else if (value.present() || use->required) {
            key.set(fault, value.value(use->rule));
        }
    }
    return fault;
}

std::vector<Fault> read_faults(const Entry& entry, const std::vector<Renderer>& renderers) {
    std::vector<std::string> names;
    names.reserve(renderers.size());
    for (const Renderer& renderer : renderers) names.push_back(renderer.name);
    std::vector<Fault> faults;
    for (const Entry& fault : entry.items()) faults.push_back(read_fault(fault, names));
    return faults;
}

/// The keys that name the files of a frame, as messages have them.
struct ImageKeys {
    std::string image;
    std::string depth;
    ImageFiles files;

    [[noreturn]] void fail(const std::string& fault) const {
        // The fault starts with the file's name, which distinguishes the two keys.
        const bool is_depth = files.depth.has_value() && files.depth != files.image &&
                              fault.rfind(text::one_line(files.depth->string()) + ": ", 0) == 0;
        throw InputError(text::one_line((is_depth ? depth : image) + ": " + fault));
    }
};

const std::shared_ptr<const StoredImage>& image_of(const FrameSource& source, const Scenario& scenario,
                                                   ImageCache& cache) {
    const ImageKeys keys{source.entry.child("image").where(), source.entry.child("depth").where(),
                         source.files};
    ImageReading reading = scenario.image_reading;
    if (source.files.depth_range) std::tie(reading.near, reading.far) = *source.files.depth_range;
    try {
        return cache.image_of({source.files, scenario.depth_format, reading},
                              [keys](const std::string& fault) { keys.fail(fault); });
    } catch (const InputError& error) {
        keys.fail(error.what());
    }
}

void split_viewport_of(RendererFrame& frame, const Entry& entry, const Renderer& renderer,
                       const Scenario& scenario) {
    if (!frame.viewport.has_value()) return;
    try {
        frame.table = scenario.table_for(*frame.viewport, renderer);
    } catch (const std::invalid_argument& error) {
        entry.child("viewport").fail(error.what());
    }
}

/// The controls of a frame, whose size is known now, and the table that they carry.
void read_controls_of(RendererFrame& frame, const Entry& entry, const Renderer& renderer) {
    const Entry controls = entry.child("controls");
    if (!controls.present()) return;
    const std::vector<Entry> scanlines = controls.items();
    if (scanlines.size() != 2) {
        controls.fail("has " + std::to_string(scanlines.size()) + " entries; use two, [colour, depth]");
    }
    const auto pixels_of = [&renderer](const Entry& scanline) {
        auto pixels = scanline_of_hex(scanline.text(), renderer.image_width_pixels);
        if (!pixels) {
            scanline.fail("is not a control scanline; use two hexadecimal digits for each byte, at most " +
                          std::to_string(renderer.image_width_pixels * kLinkBytesPerPixel) + " bytes");
        }
        return std::move(*pixels);
    };
    frame.controls = sent_controls(pixels_of(scanlines[0]), pixels_of(scanlines[1]));
    frame.table = frame.controls->table;
}

/// The image of a live renderer before its application has come: nothing.
void make_live(Renderer& renderer, ImageSize size, DepthFormat format) {
    renderer.image_width_pixels = size.width_pixels;
    renderer.image_height_pixels = size.height_pixels;
    renderer.images = {std::make_shared<const StoredImage>(size, [size, format] {
        PixelImage image(size.width_pixels, size.height_pixels);
        std::fill(image.values.begin(), image.values.end(), Pixel(0, 0, 0, 0, far_z(format)));
        return ReadImage{std::move(image), {}};
    })};
}

/// Reads the headers of one renderer's images and splits its viewports.
void read_images(const RendererSource& source, Scenario& scenario, ImageCache& cache, Renderer& renderer) {
    std::map<const StoredImage*, std::size_t> indices;  // into the renderer's own list
    for (std::size_t i = 0; i < source.frames.size(); ++i) {
        const FrameSource& frame_source = source.frames[i];
        RendererFrame& frame = renderer.frames[i];
        const std::shared_ptr<const StoredImage>& image = image_of(frame_source, scenario, cache);
        const auto [known, is_new] = indices.try_emplace(image.get(), renderer.images.size());
        if (is_new) {
            renderer.images.push_back(image);
            scenario.image_files.insert_or_assign(image.get(), frame_source.files);
        }
        frame.image = known->second;
        const StoredImage& first = *renderer.images.front();
        renderer.image_width_pixels = first.width_pixels();
        renderer.image_height_pixels = first.height_pixels();
        split_viewport_of(frame, frame_source.entry, renderer, scenario);
        read_controls_of(frame, frame_source.entry, renderer);
    }
}

void read_images(Draft& draft, ImageCache& cache, LiveRenderers live) {
    for (const RendererSource& source : draft.sources) {
        Renderer& original = draft.scenario.renderers[source.first];
        if (original.is_live) {
            if (live == LiveRenderers::kRefused) refuse_live(source.entry.child("live"));
            make_live(original, source.live, draft.scenario.depth_format);
        }
        read_images(source, draft.scenario, cache, original);
        for (std::size_t i = 1; i < static_cast<std::size_t>(source.copies); ++i) {
            Renderer& copy = draft.scenario.renderers[source.first + i];
            std::string name = std::move(copy.name);
            copy = original;
            copy.name = std::move(name);
        }
    }
}

/// What a rule names, as the file has it.
struct KeyInFile {
    std::string path;
    std::optional<int> number{};  ///< of the frame, if the file has it in a range
};

/// A rule names renderers and frames by index: copies, and frames of a range, have their own indices.
KeyInFile key_in_file(const std::string& path, const Draft& draft) {
    const std::string renderers = "renderers[";
    if (path.rfind(renderers, 0) != 0) return {path};
    const std::size_t renderer = std::stoul(path.substr(renderers.size()));
    const auto source = std::prev(
        std::upper_bound(draft.sources.begin(), draft.sources.end(), renderer,
                         [](std::size_t index, const RendererSource& other) { return index < other.first; }));
    KeyInFile key{renderers + std::to_string(source - draft.sources.begin())};
    const std::string rest = path.substr(path.find(']'));
    const std::string frames = "].frames[";
    if (rest.rfind(frames, 0) != 0) {
        key.path += rest;
        return key;
    }
    const FrameSource& frame = source->frames[std::stoul(rest.substr(frames.size()))];
    key.path += frames + std::to_string(frame.index) + rest.substr(rest.find(']', 1));
    key.number = frame.number;
    return key;
}

/// Turns a broken rule into an error with the line of what broke it.
void throw_if(const std::optional<RuleViolation>& violation, const Draft& draft, const Value& tree) {
    if (!violation.has_value()) return;
    const KeyInFile key = key_in_file(violation->path, draft);
    const std::string frame = key.number ? " (frame " + std::to_string(*key.number) + ")" : "";
    throw InputError(text::one_line(find_location(tree, key.path).describe() + ": " + key.path + frame +
                                    ": " + violation->message));
}

Draft read_draft(const Value& tree, const std::string& default_name, const std::filesystem::path& base) {
    check_structure(tree, scenario_schema());
    const Entry root(tree, scenario_schema());
    Draft draft;
    Scenario& scenario = draft.scenario;
    if (const Entry displays = root.child("displays"); !displays.present()) {
        displays.fail("is missing; use a map with at least the keys width and height");
    }
    scenario.name = default_name;
    read_keys(root, setting_rows(), 0, scenario);
    read_depth_nothing(root.child("depth_nothing"), scenario.image_reading);
    scenario.displays.correction = read_corrections(correction_of(root), base);

    draft.sources = read_renderers(root.child("renderers"), base, depths_of(scenario.image_reading));
    make_renderers(draft);
    scenario.faults = read_faults(root.child("faults"), scenario.renderers);
    if (!root.child("frames").present()) {
        std::size_t longest = 1;
        for (const RendererSource& source : draft.sources) longest = std::max(longest, source.frames.size());
        scenario.frames = static_cast<int>(std::min<std::size_t>(longest, limits::kFrames.high));
    }
    throw_if(settings_violation(scenario), draft, tree);
    return draft;
}

void read_colour_tables(const Value& tree, DisplayConfig& displays, ImageCache& cache) {
    const std::vector<Entry> entries = correction_of(Entry(tree, scenario_schema())).items();
    for (std::size_t i = 0; i < displays.correction.size(); ++i) {
        DisplayCorrection& correction = displays.correction[i];
        if (!correction.has_lut()) continue;
        try {
            correction.lut = cache.colour_table_of(correction.lut_file);
        } catch (const InputError& error) {
            entries[i].child("lut").fail(error.what());
        }
    }
}

}  // namespace

void refuse_live(const Entry& live) {
    live.fail("gets its images from an application; use metabuffer live, or frames with images");
}

Scenario read_settings(const Value& tree, const std::string& default_name) {
    return read_draft(tree, default_name, {}).scenario;
}

Scenario read_scenario(const Value& tree, const std::string& default_name, const std::filesystem::path& base,
                       ImageCache& cache, LiveRenderers live) {
    // Reading images takes longest: everything else is checked first.
    Draft draft = read_draft(tree, default_name, base);
    read_colour_tables(tree, draft.scenario.displays, cache);
    read_images(draft, cache, live);
    ClockConfig& clocks = draft.scenario.clocks;
    if (!clocks.dvi_in_is_known()) {
        clocks.dvi_in_mhz =
            mhz_of_refresh(*clocks.given_dvi_in_refresh_hz, draft.scenario.renderers.front().timing());
    }
    throw_if(renderers_violation(draft.scenario), draft, tree);
    return std::move(draft.scenario);
}

}  // namespace metabuffer::input
