#pragma once

#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <tuple>
#include <utility>

#include "formats/image.h"
#include "images/image_codec.h"
#include "scenario/scenario.h"
#include "scenario/yaml_reader.h"

/// From a scenario's YAML, overrides in place, to the scenario.
namespace metabuffer::input {

/// A cache of images by their files. Each is read once, however many renderers and scenarios show it. An image that
/// fails twice in the same way is not tried a third time.
class ImageShelf {
  public:
    /// load: reads an image. Throws InputError.
    explicit ImageShelf(LoadImage load) : load_(std::move(load)) {}

    /// What a pixel depends on: the files, and how depths become Z (format, near, far).
    using Key = std::tuple<ImageFiles, DepthFormat, double, double>;

    /// The image. The reference stays valid as long as the cache lives. Throws InputError.
    const std::shared_ptr<const PixelImage>& image_of(const Key& key);

  private:
    LoadImage load_;
    std::map<Key, std::shared_ptr<const PixelImage>> images_;
    struct Failure {
        std::string message;
        bool is_lasting = false;  ///< it has come twice
    };
    std::map<Key, Failure> failures_;
};

/// All except for the images and what follows from them, the tables of viewports. Throws InputError.
Scenario read_settings(const Value& tree, const std::string& default_name);

/// The whole scenario; image paths are relative to `base`. Throws InputError.
Scenario read_scenario(const Value& tree, const std::string& default_name, const std::filesystem::path& base,
                       ImageShelf& shelf);

}  // namespace metabuffer::input
