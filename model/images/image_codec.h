#pragma once

#include <filesystem>
#include <memory>
#include <string>

#include "formats/depth_format.h"
#include "formats/image.h"
#include "images/image_source.h"

namespace metabuffer {

/// Reads and writes image files by OpenImageIO.
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

/// The program's codec, which does its work in a process of its own (image_service.h). Call it before this process forks
/// if the children need it too, or each starts such a process. Throws InputError if this computer cannot start it.
const ImageCodec& image_codec();

/// Reads images by the program's codec, which is started for the first one.
std::shared_ptr<const ImageSource> images_of_codec();

}  // namespace metabuffer
