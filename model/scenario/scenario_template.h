#pragma once

#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "host/errors.h"
#include "images/image_codec.h"
#include "scenario/scenario_loader.h"

namespace metabuffer {

/// A scenario file read once, from which many scenarios are made that differ in their overrides. Images are kept, so
/// that the second scenario that shows one does not read it again. Not for two threads at the same time; a process may
/// fork, and both processes may go on with it.
class ScenarioTemplate {
  public:
    /// Reads the file, not its images. Throws InputError.
    explicit ScenarioTemplate(const std::filesystem::path& file,
                              std::shared_ptr<const ImageSource> images = images_of_codec());
    /// The same from text; `origin` names it in messages and `base` is what image paths are relative to.
    ScenarioTemplate(std::string text, const std::string& origin, const std::filesystem::path& base,
                     std::shared_ptr<const ImageSource> images = images_of_codec());
    ScenarioTemplate(ScenarioTemplate&&) noexcept;
    ScenarioTemplate& operator=(ScenarioTemplate&&) noexcept;
    ~ScenarioTemplate();

    /// The file, or the origin of the text.
    const std::filesystem::path& file() const;
    /// The file's text.
    const std::string& text() const;
    /// The scenario with these overrides, as load_scenario() makes it. Throws InputError.
    Scenario scenario(const std::vector<ScenarioOverride>& overrides,
                      LiveRenderers live = LiveRenderers::kRefused) const;
    /// Throws InputError if a renderer gets its images from an application: only metabuffer live has any.
    void refuse_live() const;
    /// The files of images, depths and colour tables that the scenario with these overrides names, each once, whether
    /// they are there or not. Throws InputError for overrides that cannot be applied.
    std::vector<std::filesystem::path> input_files(const std::vector<ScenarioOverride>& overrides) const;
    /// As scenario_settings() has them (scenario_writer.h), with overrides and defaults filled in. Reads no images, and
    /// checks what can be checked without. Throws InputError.
    std::map<std::string, std::string> settings(const std::vector<ScenarioOverride>& overrides) const;

  private:
    struct Content;
    std::unique_ptr<Content> content_;
};

/// The keys that settings() has, in the order of the documentation.
std::vector<std::string> setting_keys();

}  // namespace metabuffer
