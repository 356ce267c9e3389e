#include "scenario/scenario_template.h"

#include <optional>
#include <set>
#include <utility>

#include "host/text.h"
#include "host/text_file.h"
#include "scenario/entry.h"
#include "scenario/frame_pattern.h"
#include "scenario/limits.h"
#include "scenario/scenario_keys.h"
#include "scenario/scenario_reader.h"
#include "scenario/scenario_writer.h"

namespace metabuffer {
namespace {

/// The names of a range of frames, or the name itself.
std::vector<std::string> numbered_names(const std::string& name, const std::string& range) {
    const std::optional<input::FrameNumbers> numbers = input::parse_frame_numbers(range);
    if (!numbers || numbers->count() > limits::kNumberedFrames) return {name};
    std::vector<std::string> names;
    for (int number = numbers->first; number <= numbers->last; ++number) {
        names.push_back(input::numbered_name(name, number).value_or(name));
    }
    return names;
}

using Files = std::set<std::filesystem::path>;

void add_images(const input::Entry& root, const std::filesystem::path& base, Files& files) {
    for (const input::Entry& renderer : root.child("renderers").items()) {
        for (const input::Entry& frame : renderer.child("frames").items()) {
            for (const char* key : {"image", "depth"}) {
                const std::string name = frame.child(key).text();
                if (name.empty()) continue;
                for (const std::string& numbered : numbered_names(name, frame.child("frames").text())) {
                    files.insert(base / numbered);
                }
            }
        }
    }
}

void add_colour_tables(const input::Entry& root, const std::filesystem::path& base, Files& files) {
    for (const input::Entry& correction : root.at("displays.correction").items()) {
        const std::string name = correction.child("lut").text();
        if (!name.empty()) files.insert(base / name);
    }
}

}  // namespace

struct ScenarioTemplate::Content {
    explicit Content(std::shared_ptr<const ImageSource> images) : cache(std::move(images)) {}

    std::filesystem::path file;
    std::string text;
    std::filesystem::path base;
    std::string default_name;
    input::Value tree;
    input::ImageCache cache;

    /// Calls read with the tree that has the overrides in it.
    template <typename Read>
    auto with(const std::vector<ScenarioOverride>& overrides, Read read) const {
        if (overrides.empty()) return read(tree);
        input::Value changed = tree;
        for (const ScenarioOverride& override_ : overrides) {
            input::apply_override(changed, scenario_schema(), override_.path, override_.value);
        }
        return read(changed);
    }
};

ScenarioTemplate::ScenarioTemplate(const std::filesystem::path& file,
                                   std::shared_ptr<const ImageSource> images)
    : ScenarioTemplate(input::text_of_file(file), file.string(), file.parent_path(), std::move(images)) {}

ScenarioTemplate::ScenarioTemplate(std::string text, const std::string& origin,
                                   const std::filesystem::path& base,
                                   std::shared_ptr<const ImageSource> images)
    : content_(std::make_unique<Content>(std::move(images))) {
    content_->file = origin;
    content_->base = base;
    content_->default_name = text::one_line(content_->file.stem().string());
    if (content_->default_name.empty()) content_->default_name = "scenario";
    content_->tree = input::parse_yaml(text, std::make_shared<const std::string>(origin), true);
    content_->text = std::move(text);
}

ScenarioTemplate::ScenarioTemplate(ScenarioTemplate&&) noexcept = default;
ScenarioTemplate& ScenarioTemplate::operator=(ScenarioTemplate&&) noexcept = default;
ScenarioTemplate::~ScenarioTemplate() = default;

const std::filesystem::path& ScenarioTemplate::file() const { return content_->file; }

const std::string& ScenarioTemplate::text() const { return content_->text; }

Scenario ScenarioTemplate::scenario(const std::vector<ScenarioOverride>& overrides,
                                    LiveRenderers live) const {
    return content_->with(overrides, [this, live](const input::Value& tree) {
        return input::read_scenario(tree, content_->default_name, content_->base, content_->cache, live);
    });
}

void ScenarioTemplate::refuse_live() const {
    const input::Entry root(content_->tree, scenario_schema());
    for (const input::Entry& renderer : root.child("renderers").items()) {
        if (const input::Entry live = renderer.child("live"); live.present()) input::refuse_live(live);
    }
}

std::vector<std::filesystem::path> ScenarioTemplate::input_files(
    const std::vector<ScenarioOverride>& overrides) const {
    return content_->with(overrides, [this](const input::Value& tree) {
        Files files;
        const input::Entry root(tree, scenario_schema());
        add_images(root, content_->base, files);
        add_colour_tables(root, content_->base, files);
        return std::vector<std::filesystem::path>(files.begin(), files.end());
    });
}

std::map<std::string, std::string> ScenarioTemplate::settings(
    const std::vector<ScenarioOverride>& overrides) const {
    return content_->with(overrides, [this](const input::Value& tree) {
        return scenario_settings(input::read_settings(tree, content_->default_name));
    });
}

std::vector<std::string> setting_keys() {
    std::vector<std::string> keys;
    for (const ObjectKey<Scenario>& key : setting_rows()) {
        if (key.schema.shape == KeyShape::kScalar && key.value != nullptr) {
            keys.emplace_back(key.schema.pattern);
        }
    }
    return keys;
}

}  // namespace metabuffer
