#include "scenario/scenario_writer.h"

#include <algorithm>
#include <map>
#include <sstream>
#include <stdexcept>
#include <string>
#include <system_error>
#include <vector>

#include "host/errors.h"
#include "host/output_file.h"
#include "host/text.h"
#include "images/image_codec.h"
#include "scenario/colour_table_file.h"
#include "scenario/fault_keys.h"
#include "scenario/names.h"
#include "scenario/scenario_keys.h"
#include "scenario/yaml_reader.h"

namespace metabuffer {
namespace {

constexpr const char* kScenarioFile = "scenario.yaml";

/// A name as a YAML scalar that means just itself.
std::string name(const std::string& key, const std::string& words) {
    if (words.empty() || text::has_control(words)) {
        throw InputError(key + ": " + text::quoted(words) +
                         " cannot be written to a scenario file; use a name on one line");
    }
    return input::quoted_scalar(words);
}

// ---- images and colour tables ----

/// Where the images and colour tables of a scenario are written to or found.
class FileNames {
  public:
    FileNames() = default;
    FileNames(const FileNames&) = delete;
    FileNames& operator=(const FileNames&) = delete;
    virtual ~FileNames() = default;
    /// The files of an image, relative to the scenario's.
    virtual ImageFiles files_of(const StoredImage& image) = 0;
    /// The same for the table of a display.
    virtual std::filesystem::path table_file_of(const DisplayCorrection& correction) = 0;
};

/// Images in separate files, each once, however many frames and renderers show it, and a file for each display's table.
class WrittenFiles final : public FileNames {
  public:
    ImageFiles files_of(const StoredImage& image) override {
        const auto [known, is_new] = numbers_.try_emplace(&image, images_.size() + 1);
        if (is_new) images_.push_back(&image);
        return {colour_file(known->second), depth_file(known->second), std::nullopt};
    }

    std::filesystem::path table_file_of(const DisplayCorrection& correction) override {
        tables_.push_back(&correction);
        return table_file(correction);
    }

    /// Writes all that files_of and table_file_of were asked for.
    void write(const std::filesystem::path& directory, DepthFormat format) const {
        for (std::size_t number = 1; number <= images_.size(); ++number) {
            const PixelImage& image = images_[number - 1]->pixels();
            const std::filesystem::path colours = directory / colour_file(number);
            const std::filesystem::path depths = directory / depth_file(number);
            write_output_file(colours, image_codec().colour_tiff(image, colours));
            write_output_file(depths, image_codec().depth_tiff(image, format, depths));
        }
        for (const DisplayCorrection* correction : tables_) {
            write_output_file(directory / table_file(*correction),
                              input::colour_table_text(correction->table()));
        }
    }

  private:
    static std::string colour_file(std::size_t number) { return "image_" + std::to_string(number) + ".tif"; }
    static std::string depth_file(std::size_t number) { return "depth_" + std::to_string(number) + ".tif"; }
    static std::string table_file(const DisplayCorrection& correction) {
        return "lut_" + std::to_string(correction.display) + ".csv";
    }

    std::vector<const StoredImage*> images_;
    std::map<const StoredImage*, std::size_t> numbers_;  ///< from 1
    std::vector<const DisplayCorrection*> tables_;
};

/// The files that the images and tables were read from.
class ReadFiles final : public FileNames {
  public:
    ReadFiles(const Scenario& scenario, const std::filesystem::path& directory)
        : scenario_(scenario), directory_(std::filesystem::absolute(directory)) {}

    ImageFiles files_of(const StoredImage& image) override {
        const ImageFiles& files = scenario_.image_files.at(&image);
        return {relative(files.image),
                files.depth ? std::optional(relative(*files.depth)) : std::nullopt,
                files.z,
                files.layer,
                files.depth_layer,
                files.depth_range};
    }

    std::filesystem::path table_file_of(const DisplayCorrection& correction) override {
        return relative(correction.lut_file);
    }

  private:
    std::filesystem::path relative(const std::filesystem::path& file) const {
        return std::filesystem::proximate(file, directory_);
    }

    const Scenario& scenario_;
    std::filesystem::path directory_;
};

// ---- the scenario's text ----

bool is_split_of_viewport(const RendererFrame& frame, const Renderer& renderer, const Scenario& scenario) {
    if (!frame.viewport.has_value()) return false;
    try {
        return frame.table == scenario.table_for(*frame.viewport, renderer);
    } catch (const std::invalid_argument&) {
        return false;
    }
}

/// In flow style: "{a: 1, b: 2}", "[1, 2]".
std::string flow_map(const std::vector<std::string>& members) { return "{" + text::listed(members) + "}"; }
std::string flow_list(const std::vector<std::string>& items) { return "[" + text::listed(items) + "]"; }

std::string value_in_file(const SchemaKey& key, const KeyValue& value) {
    return key.rule.type == ValueRule::Type::kText ? name(key.pattern, std::get<std::string>(value))
                                                   : value_text(value);
}

/// "name: value" of every key that is kept in the object and is in the map at `map`.
template <typename Object>
std::vector<std::string> members_of(const std::vector<ObjectKey<Object>>& keys, const std::string& map,
                                    const Object& object) {
    std::vector<std::string> members;
    for (const ObjectKey<Object>& key : keys) {
        const std::string path = key.schema.pattern;
        const std::size_t dot = path.rfind('.');
        const bool is_inside = dot != std::string::npos && path.compare(0, dot, map) == 0;
        if (key.value == nullptr || !is_inside) continue;
        const std::optional<KeyValue> value = key.value(object);
        if (value) members.push_back(path.substr(dot + 1) + ": " + value_in_file(key.schema, *value));
    }
    return members;
}

std::string corrections_text(const std::vector<DisplayCorrection>& corrections, FileNames& files) {
    std::vector<std::string> items;
    for (const DisplayCorrection& correction : corrections) {
        std::vector<std::string> members = members_of(correction_rows(), "displays.correction[]", correction);
        if (correction.has_lut()) {
            members = {"display: " + std::to_string(correction.display),
                       "lut: " + name("displays.correction.lut", files.table_file_of(correction).string())};
        }
        items.push_back(flow_map(members));
    }
    return flow_list(items);
}

/// The members of a map on one line.
std::string map_text(const std::string& path, const Scenario& scenario, FileNames& files) {
    std::vector<std::string> members = members_of(setting_rows(), path, scenario);
    for (const ObjectKey<Scenario>& key : setting_rows()) {
        const std::string inner = key.schema.pattern;
        if (key.schema.shape == KeyShape::kMap && inner.rfind(path + ".", 0) == 0) {
            members.push_back(inner.substr(path.size() + 1) + ": " + map_text(inner, scenario, files));
        }
    }
    const std::vector<DisplayCorrection>& corrections = scenario.displays.correction;
    if (path == "displays" && !corrections.empty()) {
        members.push_back("correction: " + corrections_text(corrections, files));
    }
    return flow_map(members);
}

/// Every key of the machine; the keys of a map go on the map's line.
void write_settings(std::ostream& out, const Scenario& scenario, FileNames& files) {
    for (const ObjectKey<Scenario>& key : setting_rows()) {
        const std::string path = key.schema.pattern;
        if (path.empty() || path.find_first_of(".[") != std::string::npos) continue;
        out << path << ": "
            << (key.schema.shape == KeyShape::kMap ? map_text(path, scenario, files)
                                                   : value_in_file(key.schema, *key.value(scenario)))
            << "\n";
    }
}

std::string table_text(const ViewportTable& table) {
    std::vector<std::string> rows;
    for (const ViewportRow& row : table) {
        std::vector<std::string> fields;
        for (const TableField& field : table_fields()) fields.push_back(std::to_string(field.value(row)));
        rows.push_back(flow_list(fields));
    }
    return flow_list(rows);
}

std::string slots_text(const std::vector<int>& displays) {
    std::vector<std::string> slots;
    slots.reserve(displays.size());
    for (const int display : displays) slots.push_back(std::to_string(display));
    return flow_list(slots);
}

void write_renderer(std::ostream& out, const Renderer& renderer, const Scenario& scenario, FileNames& names) {
    out << "  - name: " << name("renderers.name", renderer.name) << "\n    frames:\n";
    for (const RendererFrame& frame : renderer.frames) {
        const ImageFiles files = names.files_of(*renderer.images[frame.image]);
        std::vector<std::string> members{"image: " + name("renderers.frames.image", files.image.string())};
        if (files.layer) members.push_back("layer: " + name("renderers.frames.layer", *files.layer));
        if (files.depth) {
            members.push_back("depth: " + name("renderers.frames.depth", files.depth->string()));
        }
        if (files.depth_layer) {
            members.push_back("depth_layer: " + name("renderers.frames.depth_layer", *files.depth_layer));
        }
        if (files.depth_range) {
            const auto& [near, far] = *files.depth_range;
            members.push_back("depth_range: " + flow_list({text::number(near), text::number(far)}));
        }
        if (files.z) members.push_back("z: " + text::number(*files.z));
        if (frame.controls) {
            members.push_back("controls: " +
                              flow_list({input::quoted_scalar(hex_of_scanline(frame.controls->colour)),
                                         input::quoted_scalar(hex_of_scanline(frame.controls->depth))}));
        } else if (is_split_of_viewport(frame, renderer, scenario)) {
            const std::string path = "renderers[].frames[].viewport";
            members.push_back("viewport: " + flow_map(members_of(viewport_rows(), path, *frame.viewport)));
        } else {
            members.push_back("table: " + table_text(frame.table));
        }
        if (frame.slots) members.push_back("slots: " + slots_text(*frame.slots));
        out << "      - " << flow_map(members) << "\n";
    }
}

void write_fault(std::ostream& out, const Fault& fault, const Scenario& scenario) {
    std::vector<std::string> members;
    if (fault_traits(fault.kind).names_renderer()) {
        const Renderer& renderer = scenario.renderers[static_cast<std::size_t>(fault.renderer)];
        members.push_back("renderer: " + name("faults.renderer", renderer.name));
    }
    members.push_back(std::string("kind: ") + to_string(fault.kind));
    for (const FaultKeyUse& use : fault_keys_of(fault.kind)) {
        const std::optional<KeyValue> value = use.key->value(fault);
        if (value) members.push_back(use.key->name() + (": " + value_text(*value)));
    }
    out << "  - " << flow_map(members) << "\n";
}

std::string scenario_text(const Scenario& scenario, FileNames& files) {
    std::ostringstream out;
    write_settings(out, scenario, files);
    out << "renderers:\n";
    for (const Renderer& renderer : scenario.renderers) {
        write_renderer(out, renderer, scenario, files);
    }
    if (!scenario.faults.empty()) out << "faults:\n";
    for (const Fault& fault : scenario.faults) write_fault(out, fault, scenario);
    return out.str();
}

}  // namespace

std::map<std::string, std::string> scenario_settings(const Scenario& scenario) {
    std::map<std::string, std::string> settings;
    for (const ObjectKey<Scenario>& key : setting_rows()) {
        if (key.schema.shape != KeyShape::kScalar || key.value == nullptr) continue;
        const std::optional<KeyValue> value = key.value(scenario);
        if (value) settings.emplace(key.schema.pattern, value_text(*value));
    }
    return settings;
}

void write_scenario(const Scenario& scenario, const std::filesystem::path& directory) {
    WrittenFiles files;
    Scenario written = scenario;
    // Its files have Z as a share of their full scale, whatever those have had that it was read from.
    written.image_reading = {scenario.image_reading.nearest(), scenario.image_reading.farthest()};
    const std::string content = scenario_text(written, files);
    std::error_code error;
    std::filesystem::create_directories(directory, error);
    if (error) fail_to_write(directory, error.message());
    // An earlier scenario's text must not be left next to this one's images if these cannot all be written.
    std::filesystem::remove(directory / kScenarioFile, error);
    files.write(directory, scenario.depth_format);
    write_output_file(directory / kScenarioFile, content);
}

std::string effective_scenario(const Scenario& scenario, const std::filesystem::path& directory) {
    ReadFiles files(scenario, directory);
    return scenario_text(scenario, files);
}

}  // namespace metabuffer
