#include "images/image_module.h"

#include <fcntl.h>
#include <unistd.h>

#include <array>
#include <cstddef>
#include <cstdio>

#include "images/image_encoder.h"
#include "images/image_reader.h"

namespace metabuffer {
namespace {

/// While it lives, what libraries print about an image is discarded: libpng and libtiff print, and this cannot be
/// switched off. They also report to the caller what is wrong with the image.
class QuietLibraries {
  public:
    QuietLibraries() {
        std::fflush(nullptr);  // the program's own output that is still buffered
        const int nowhere = open("/dev/null", O_WRONLY | O_CLOEXEC);
        for (std::size_t i = 0; nowhere >= 0 && i < kStreams.size(); ++i) {
            saved_[i] = fcntl(kStreams[i], F_DUPFD_CLOEXEC, 0);
            if (saved_[i] >= 0) dup2(nowhere, kStreams[i]);
        }
        if (nowhere >= 0) close(nowhere);
    }
    QuietLibraries(const QuietLibraries&) = delete;
    QuietLibraries& operator=(const QuietLibraries&) = delete;
    ~QuietLibraries() {
        std::fflush(nullptr);
        for (std::size_t i = 0; i < kStreams.size(); ++i) {
            if (saved_[i] < 0) continue;
            dup2(saved_[i], kStreams[i]);
            close(saved_[i]);
        }
    }

  private:
    static constexpr std::array<int, 2> kStreams{STDOUT_FILENO, STDERR_FILENO};

    std::array<int, 2> saved_{-1, -1};
};

class OpenImageIoCodec final : public ImageCodec {
  public:
    ImageSize size(const ImageFiles& files) const override {
        const QuietLibraries quiet;
        return image_size(files);
    }
    PixelImage load(const ImageFiles& files, DepthFormat format, const DepthRange& range) const override {
        const QuietLibraries quiet;
        return load_image(files, format, range);
    }
    std::string png(const ColourImage& image, const std::filesystem::path& file,
                    const std::string& description) const override {
        const QuietLibraries quiet;
        return encode_png(image, file, description);
    }
    std::string colour_tiff(const PixelImage& image, const std::filesystem::path& file) const override {
        const QuietLibraries quiet;
        return encode_colour_tiff(image, file);
    }
    std::string depth_tiff(const PixelImage& image, DepthFormat format,
                           const std::filesystem::path& file) const override {
        const QuietLibraries quiet;
        return encode_depth_tiff(image, format, file);
    }
};

}  // namespace
}  // namespace metabuffer

const metabuffer::ImageCodec* metabuffer_image_module() {
    static const metabuffer::OpenImageIoCodec codec;
    return &codec;
}
