#include "scenario/scenario_writer.h"

#include <OpenImageIO/imageio.h>

#include <algorithm>
#include <cerrno>
#include <fstream>
#include <map>
#include <sstream>
#include <stdexcept>
#include <string>
#include <system_error>
#include <vector>

#include "host/errors.h"
#include "host/text.h"
#include "scenario/fault_keys.h"
#include "scenario/names.h"
#include "scenario/scenario_keys.h"

namespace metabuffer {
namespace {

constexpr const char* kScenarioFile = "scenario.yaml";
constexpr int kColourChannels = 4;

[[noreturn]] void fail(const std::filesystem::path& file, const std::string& reason) {
    throw OutputError(text::one_line("cannot write '" + file.string() + "': " + reason));
}

/// A name as a YAML scalar that means just itself: in single quotes nothing is special but the quote.
std::string name(const std::string& key, const std::string& words) {
    const bool has_control = std::any_of(words.begin(), words.end(), [](char character) {
        return static_cast<unsigned char>(character) < 0x20U || character == 0x7F;
    });
    if (words.empty() || has_control) {
        throw InputError(key + ": " + text::quoted(words) +
                         " cannot be written to a scenario file; use a name on one line");
    }
    std::string result = "'";
    for (const char character : words) result += character == '\'' ? "''" : std::string(1, character);
    return result + "'";
}

// ---- images ----

/// The samples of one file, pixel by pixel.
template <typename Sample>
void write_tiff(const std::filesystem::path& file, const PixelImage& image,
                const std::vector<std::string>& channels, const std::vector<Sample>& samples) {
    OIIO::ImageSpec spec(image.width_pixels, image.height_pixels, static_cast<int>(channels.size()),
                         OIIO::BaseTypeFromC<Sample>::value);
    spec.channelnames = channels;
    spec.alpha_channel = spec.channelindex("A");
    // The same image makes the same file, whenever it is written.
    spec.attribute("DateTime", "1970:01:01 00:00:00");
    const auto output = OIIO::ImageOutput::create("tiff");
    if (output == nullptr) fail(file, OIIO::geterror());
    if (!output->open(file.string(), spec) ||
        !output->write_image(OIIO::BaseTypeFromC<Sample>::value, samples.data()) || !output->close()) {
        fail(file, output->geterror());
    }
}

void write_colour(const std::filesystem::path& file, const PixelImage& image) {
    std::vector<std::uint8_t> samples;
    samples.reserve(image.values.size() * kColourChannels);
    for (const Pixel pixel : image.values) {
        for (const std::uint8_t channel : {pixel.r(), pixel.g(), pixel.b(), pixel.a()}) {
            samples.push_back(channel);
        }
    }
    write_tiff(file, image, {"R", "G", "B", "A"}, samples);
}

template <typename Sample>
void write_depth(const std::filesystem::path& file, const PixelImage& image) {
    std::vector<Sample> samples;
    samples.reserve(image.values.size());
    for (const Pixel pixel : image.values) samples.push_back(static_cast<Sample>(pixel.z()));
    write_tiff(file, image, {"Z"}, samples);
}

/// Each image once, however many frames and renderers show it.
class ImageFiles {
  public:
    /// The keys of a frame that name its image.
    std::string keys_of(const PixelImage& image) {
        const auto [known, is_new] = numbers_.try_emplace(&image, images_.size() + 1);
        if (is_new) images_.push_back(&image);
        return "image: " + colour_file(known->second) + ", depth: " + depth_file(known->second);
    }

    /// Writes all that keys_of was asked for.
    void write(const std::filesystem::path& directory, DepthFormat format) const {
        for (std::size_t number = 1; number <= images_.size(); ++number) {
            const PixelImage& image = *images_[number - 1];
            write_colour(directory / colour_file(number), image);
            if (layout_of(format).z_bits <= 16) {
                write_depth<std::uint16_t>(directory / depth_file(number), image);
            } else {
                write_depth<std::uint32_t>(directory / depth_file(number), image);
            }
        }
    }

  private:
    static std::string colour_file(std::size_t number) { return "image_" + std::to_string(number) + ".tif"; }
    static std::string depth_file(std::size_t number) { return "depth_" + std::to_string(number) + ".tif"; }

    std::vector<const PixelImage*> images_;
    std::map<const PixelImage*, std::size_t> numbers_;  ///< from 1
};

// ---- the scenario's text ----

bool is_split_of_viewport(const RendererFrame& frame, const Renderer& renderer, const DisplayWall& wall) {
    if (!frame.viewport.has_value()) return false;
    try {
        return frame.table == split_viewport(*frame.viewport, renderer.image_width_pixels,
                                             renderer.image_height_pixels, wall);
    } catch (const std::invalid_argument&) {
        return false;
    }
}

std::string table_text(const ViewportTable& table) {
    std::ostringstream text;
    const char* before = "[";
    for (const ViewportRow& row : table) {
        text << before << "[" << row.dcomp << ", " << row.sx << ", " << row.sy << ", " << row.sdx << ", "
             << row.sdy << ", " << row.dx << ", " << row.dy << ", " << row.dmultiple << "]";
        before = ", ";
    }
    return table.empty() ? "[]" : text.str() + "]";
}

/// Every key of the machine, from the one list: what stands in a map goes on the map's line.
void write_settings(std::ostream& out, const Scenario& scenario) {
    const std::uint8_t* background = scenario.displays.background;
    std::map<std::string, std::string> values = scenario_settings(scenario);
    values["name"] = name("name", scenario.name);
    values["displays.background"] = "[" + std::to_string(background[0]) + ", " +
                                    std::to_string(background[1]) + ", " + std::to_string(background[2]) +
                                    "]";
    values["depth_range"] =
        "[" + text::number(scenario.depth_near) + ", " + text::number(scenario.depth_far) + "]";
    const Schema& schema = scenario_schema();
    for (const std::string& key : schema.keys_of("")) {
        if (const auto value = values.find(key); value != values.end()) {
            out << key << ": " << value->second << "\n";
        }
        if (schema.find(key)->shape != KeyShape::kMap) continue;
        const char* before = ": {";
        out << key;
        for (const std::string& inner : schema.keys_of(key)) {
            out << before << inner << ": " << values.at(key_pattern(key, inner));
            before = ", ";
        }
        out << "}\n";
    }
}

void write_renderer(std::ostream& out, const Renderer& renderer, const DisplayWall& wall,
                    ImageFiles& images) {
    out << "  - name: " << name("renderers.name", renderer.name) << "\n"
        << "    frames:\n";
    for (const RendererFrame& frame : renderer.frames) {
        out << "      - {" << images.keys_of(*renderer.images[frame.image]) << ", ";
        if (is_split_of_viewport(frame, renderer, wall)) {
            const Viewport& viewport = *frame.viewport;
            out << "viewport: {x: " << viewport.x << ", y: " << viewport.y
                << ", multiple: " << viewport.multiple << "}}\n";
        } else {
            out << "table: " << table_text(frame.table) << "}\n";
        }
    }
}

void write_fault(std::ostream& out, const Fault& fault, const Scenario& scenario) {
    const Renderer& renderer = scenario.renderers[static_cast<std::size_t>(fault.renderer)];
    out << "  - {renderer: " << name("faults.renderer", renderer.name) << ", kind: " << to_string(fault.kind);
    for (const FaultKeyUse& use : fault_keys_of(fault.kind)) {
        const std::optional<std::int64_t> value = use.key->value(fault);
        if (!value) continue;
        out << ", " << use.key->name << ": ";
        switch (use.key->shape) {
            case FaultKey::Shape::kFrame:
                out << to_string(fault.frame);
                break;
            case FaultKey::Shape::kBeats:
                out << to_string(fault.of);
                break;
            case FaultKey::Shape::kWholeNumber:
                out << *value;
                break;
        }
    }
    out << "}\n";
}

void write_text_file(const std::filesystem::path& file, const std::string& content) {
    errno = 0;
    std::ofstream stream(file, std::ios::binary | std::ios::trunc);
    stream << content;
    stream.close();
    if (!stream) fail(file, errno != 0 ? std::generic_category().message(errno) : "the stream failed");
}

}  // namespace

std::map<std::string, std::string> scenario_settings(const Scenario& scenario) {
    const DisplayConfig& displays = scenario.displays;
    return {
        {"name", scenario.name},
        {"displays.columns", std::to_string(displays.columns)},
        {"displays.rows", std::to_string(displays.rows)},
        {"displays.width", std::to_string(displays.width_pixels)},
        {"displays.height", std::to_string(displays.height_pixels)},
        {"displays.supersample", std::to_string(displays.supersample)},
        {"composition", to_string(scenario.composition)},
        {"depth_format", to_string(scenario.depth_format)},
        {"clocks.core_mhz", text::number(scenario.clocks.core_mhz)},
        {"clocks.dvi_in_mhz", text::number(scenario.clocks.dvi_in_mhz)},
        {"clocks.dvi_out_mhz", text::number(scenario.clocks.dvi_out_mhz)},
        {"memory.page_words", std::to_string(scenario.memory.page_words)},
        {"memory.page_miss_cycles", std::to_string(scenario.memory.page_miss_cycles)},
        {"memory.words_per_cycle", std::to_string(scenario.memory.words_per_cycle)},
        {"bus.width_bits", std::to_string(scenario.bus.width_bits)},
        {"bus.burst_pixels", std::to_string(scenario.bus.burst_pixels)},
        {"bus.arbitration", to_string(scenario.bus.arbitration)},
        {"composer.buffer_pixels", std::to_string(scenario.composer.buffer_pixels)},
        {"composer.ready_space_pixels", std::to_string(scenario.composer.ready_space_pixels)},
        {"composer.on_starvation", to_string(scenario.composer.on_starvation)},
        {"pacing", to_string(scenario.pacing)},
        {"link_timeout_pairs", std::to_string(scenario.link_timeout_pairs)},
        {"watchdog_cycles", std::to_string(scenario.watchdog_cycles)},
        {"frames", std::to_string(scenario.frames)},
    };
}

void write_scenario(const Scenario& scenario, const std::filesystem::path& directory) {
    std::ostringstream out;
    write_settings(out, scenario);
    out << "renderers:\n";
    ImageFiles images;
    for (const Renderer& renderer : scenario.renderers) {
        write_renderer(out, renderer, scenario.displays.wall(), images);
    }
    if (!scenario.faults.empty()) out << "faults:\n";
    for (const Fault& fault : scenario.faults) write_fault(out, fault, scenario);

    std::error_code error;
    std::filesystem::create_directories(directory, error);
    if (error) fail(directory, error.message());
    // An earlier scenario's text must not stand beside this one's images if these cannot all be written.
    std::filesystem::remove(directory / kScenarioFile, error);
    images.write(directory, scenario.depth_format);
    write_text_file(directory / kScenarioFile, out.str());
}

}  // namespace metabuffer
