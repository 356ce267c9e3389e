#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>

#include "formats/depth_format.h"
#include "formats/image.h"
#include "formats/image_files.h"

namespace metabuffer {

struct DepthRange {
    double near = 0.0;
    double far = 1.0;
};

/// Reads and writes image files by OpenImageIO. Its libraries take a third of a second to load, so they are in a
/// separate module, which is loaded for the first image.
class ImageCodec {
  public:
    ImageCodec() = default;
    ImageCodec(const ImageCodec&) = delete;
    ImageCodec& operator=(const ImageCodec&) = delete;
    virtual ~ImageCodec() = default;

    /// Reads a renderer's image: channels R G B, A where it has one (else 255), and Z, unless that is given for all of
    /// the image or comes from a separate one-channel file. image_file.h describes the formats. Throws InputError
    /// naming the file and what it lacks.
    virtual PixelImage load(const ImageFiles& files, DepthFormat format, const DepthRange& range) const = 0;

    /// The bytes of an 8-bit RGB PNG file: the same for the same picture. `file` is what an error names. Throws
    /// OutputError.
    virtual std::string png(const ColourImage& image, const std::filesystem::path& file) const = 0;

    /// The bytes of TIFF files: the colours and alpha of an image, and its Z in samples of 16 or 32 bits. Throw
    /// OutputError.
    virtual std::string colour_tiff(const PixelImage& image, const std::filesystem::path& file) const = 0;
    virtual std::string depth_tiff(const PixelImage& image, DepthFormat format,
                                   const std::filesystem::path& file) const = 0;
};

/// The codec of this process. Call it before the process forks if the children need it too, or each loads it again.
/// Throws InputError if the module cannot be loaded.
const ImageCodec& image_codec();

/// Reads an image as ImageCodec::load() does.
using LoadImage =
    std::function<PixelImage(const ImageFiles& files, DepthFormat format, const DepthRange& range)>;
/// The same, by the codec of this process.
PixelImage load_image_here(const ImageFiles& files, DepthFormat format, const DepthRange& range);

}  // namespace metabuffer
