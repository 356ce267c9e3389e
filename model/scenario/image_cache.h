#pragma once

#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <tuple>
#include <utility>

#include "formats/colour_table.h"
#include "formats/image_reading.h"
#include "formats/stored_image.h"
#include "images/image_source.h"

namespace metabuffer::input {

/// A cache of images and colour tables by their files. Each image is read once, however many renderers and scenarios
/// show it: its headers at once, its pixels when they are needed. Headers that fail twice in the same way are not tried a
/// third time.
class ImageCache {
  public:
    explicit ImageCache(std::shared_ptr<const ImageSource> source) : source_(std::move(source)) {}

    /// What a pixel depends on.
    using Key = std::tuple<ImageFiles, DepthFormat, ImageReading>;

    /// Throws the InputError for an image's fault, whose message says where the scenario names the image.
    using Fail = std::function<void(const std::string& fault)>;

    /// The image. The reference stays valid as long as the cache lives. Throws InputError if a header has a fault.
    /// fail_later: for a fault of the pixels; it outlives the scenario's text.
    const std::shared_ptr<const StoredImage>& image_of(const Key& key, Fail fail_later);

    /// The colour table, which is read once. Throws InputError.
    const std::shared_ptr<const ColourTable>& colour_table_of(const std::filesystem::path& file);

  private:
    std::shared_ptr<const ImageSource> source_;
    std::map<Key, std::shared_ptr<const StoredImage>> images_;
    std::map<std::filesystem::path, std::shared_ptr<const ColourTable>> colour_tables_;
    struct Failure {
        std::string message;
        bool is_lasting = false;  ///< it has come twice
    };
    std::map<Key, Failure> failures_;
};

}  // namespace metabuffer::input
