#pragma once

#include "formats/depth_format.h"
#include "formats/image.h"
#include "formats/image_files.h"
#include "formats/image_reading.h"

namespace metabuffer {

/// Reads renderers' images: R, G, B, A where the file has it (else 255), and Z. An image is upright, whatever orientation
/// its file has, and is as large as the display window that its file names. What no file says of a pixel: colour 0, alpha
/// 0 and Z far. image_file.h describes the formats, image_channels.h which channels count.
class ImageSource {
  public:
    ImageSource() = default;
    ImageSource(const ImageSource&) = delete;
    ImageSource& operator=(const ImageSource&) = delete;
    virtual ~ImageSource() = default;

    /// The image's size, by the headers of its files. Throws InputError naming the file and what it lacks.
    virtual ImageSize size(const ImageFiles& files) const = 0;
    /// The image. Throws InputError as size() does, and for a fault of the pixels.
    virtual ReadImage load(const ImageFiles& files, DepthFormat format,
                           const ImageReading& reading) const = 0;
};

}  // namespace metabuffer
