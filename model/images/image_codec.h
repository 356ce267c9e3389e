#pragma once

#include <filesystem>
#include <memory>
#include <string>

#include "formats/depth_format.h"
#include "formats/image.h"
#include "images/image_source.h"

namespace metabuffer {

/// Reads and writes image files by OpenImageIO. Its libraries take a third of a second to load, so they are in a
/// separate module, which is loaded for the first image.
class ImageCodec : public ImageSource {
  public:
    /// The bytes of an 8-bit RGB PNG file: the same for the same picture. `file` is what an error names. `description`
    /// becomes the file's text of that name, unless it is empty. Throws OutputError.
    virtual std::string png(const ColourImage& image, const std::filesystem::path& file,
                            const std::string& description) const = 0;
    std::string png(const ColourImage& image, const std::filesystem::path& file) const {
        return png(image, file, std::string());
    }

    /// The bytes of TIFF files: the colours and alpha of an image, and its Z in samples of 16 or 32 bits. Throw
    /// OutputError.
    virtual std::string colour_tiff(const PixelImage& image, const std::filesystem::path& file) const = 0;
    virtual std::string depth_tiff(const PixelImage& image, DepthFormat format,
                                   const std::filesystem::path& file) const = 0;
};

/// The codec of this process. Call it before the process forks if the children need it too, or each loads it again.
/// Throws InputError if the module cannot be loaded.
const ImageCodec& image_codec();

/// Reads images by the codec of this process, which is loaded for the first one.
std::shared_ptr<const ImageSource> images_here();

}  // namespace metabuffer
