#pragma once

#include <sys/types.h>

#include <memory>

#include "images/image_codec.h"

namespace metabuffer {

/// Reads images in a process of its own, which is started for the first of them. OpenImageIO's libraries are loaded
/// there, and this process stays small: a fork copies far fewer pages.
class ImageProcess {
  public:
    ImageProcess();
    ImageProcess(const ImageProcess&) = delete;
    ImageProcess& operator=(const ImageProcess&) = delete;
    /// Ends the process.
    ~ImageProcess();

    /// As ImageCodec::load(). Throws InputError naming the image, too, if the process ends while it reads. Without a
    /// process, and in a child of the one that made this object, it reads the image itself.
    PixelImage load(const ImageFiles& files, DepthFormat format, const DepthRange& range);

  private:
    class Reader;

    pid_t owner_;
    std::unique_ptr<Reader> reader_;
};

}  // namespace metabuffer
