#pragma once

#include "formats/depth_format.h"
#include "formats/image.h"
#include "formats/image_files.h"

namespace metabuffer {

struct DepthRange {
    double near = 0.0;
    double far = 1.0;
};

/// Reads renderers' images: channels R G B, A where the file has it (else 255), and Z, unless that is given for all of
/// the image or comes from a separate one-channel file. image_file.h describes the formats.
class ImageSource {
  public:
    ImageSource() = default;
    ImageSource(const ImageSource&) = delete;
    ImageSource& operator=(const ImageSource&) = delete;
    virtual ~ImageSource() = default;

    /// The image's size, by the headers of its files. Throws InputError naming the file and what it lacks.
    virtual ImageSize size(const ImageFiles& files) const = 0;
    /// The image. Throws InputError as size() does, and for a fault of the pixels.
    virtual PixelImage load(const ImageFiles& files, DepthFormat format, const DepthRange& range) const = 0;
};

}  // namespace metabuffer
