#pragma once

#include <sys/types.h>

#include <memory>

#include "images/image_codec.h"

namespace metabuffer {

/// Reads images in a separate process, which is started for the first image. OpenImageIO's libraries are loaded there,
/// and this process stays small: a fork copies far fewer pages.
class ImageProcess {
  public:
    ImageProcess();
    ImageProcess(const ImageProcess&) = delete;
    ImageProcess& operator=(const ImageProcess&) = delete;
    /// Ends the process.
    ~ImageProcess();

    /// As ImageCodec::load(). It reads the image itself if there is no process, once the process has given no answer,
    /// and in a child of the process that made this object. So only an image's own fault is an InputError.
    PixelImage load(const ImageFiles& files, DepthFormat format, const DepthRange& range);

  private:
    class Reader;

    static std::unique_ptr<Reader> started();

    pid_t owner_;
    std::unique_ptr<Reader> reader_;
    bool reads_here_ = false;  ///< from the first image on for which the process gave no answer
};

}  // namespace metabuffer
