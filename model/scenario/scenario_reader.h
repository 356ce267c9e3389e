#pragma once

#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <tuple>

#include "formats/image.h"
#include "scenario/scenario.h"
#include "scenario/yaml_reader.h"

/// From a scenario's YAML, overrides in place, to the scenario.
namespace metabuffer::input {

/// Images by their files, each read once however many renderers and scenarios show it.
class ImageShelf {
  public:
    /// What a pixel depends on: the files, and how depths become Z (format, near, far).
    using Key = std::tuple<ImageFiles, DepthFormat, double, double>;

    /// The image, made by `load` if it is not there yet. Stays where it is for as long as the shelf lives.
    template <typename Load>
    const std::shared_ptr<const PixelImage>& image_of(const Key& key, Load load) {
        const auto known = images_.find(key);
        if (known != images_.end()) return known->second;
        return images_.emplace(key, std::make_shared<const PixelImage>(load())).first->second;
    }

  private:
    std::map<Key, std::shared_ptr<const PixelImage>> images_;
};

/// All but the images and what follows from them, the tables of viewports. Throws InputError.
Scenario read_settings(const Value& tree, const std::string& default_name);

/// The whole; image paths are relative to `base`. Throws InputError.
Scenario read_scenario(const Value& tree, const std::string& default_name, const std::filesystem::path& base,
                       ImageShelf& shelf);

}  // namespace metabuffer::input
