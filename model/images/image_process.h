#pragma once

#include <sys/types.h>

#include <memory>

#include "images/image_source.h"

namespace metabuffer {

/// Reads images in a separate process, which is started for the first image. OpenImageIO's libraries are loaded there,
/// and this process stays small: a fork copies far fewer pages.
class ImageProcess final : public ImageSource {
  public:
    ImageProcess();
    /// Ends the process.
    ~ImageProcess() override;

    /// As the codec has them. It reads the image itself if there is no process, once the process has given no answer,
    /// and in a child of the process that made this object. So only an image's own fault is an InputError.
    ImageSize size(const ImageFiles& files) const override;
    PixelImage load(const ImageFiles& files, DepthFormat format, const DepthRange& range) const override;

  private:
    class Reader;

    static std::unique_ptr<Reader> started();

    /// The process; null if this one must read.
    Reader* reader() const;
    void give_up() const;

    pid_t owner_;
    mutable std::unique_ptr<Reader> reader_;
    mutable bool reads_here_ = false;  ///< from the first image on for which the process gave no answer
};

}  // namespace metabuffer
