#include "images/image_module.h"

#include "images/image_encoder.h"
#include "images/image_reader.h"

namespace metabuffer {
namespace {

class OpenImageIoCodec final : public ImageCodec {
  public:
    PixelImage load(const std::filesystem::path& colour_file,
                    const std::optional<std::filesystem::path>& depth_file, DepthFormat format,
                    const DepthRange& range) const override {
        return load_image(colour_file, depth_file, format, range);
    }
    std::string png(const ColourImage& image, const std::filesystem::path& file) const override {
        return encode_png(image, file);
    }
    std::string colour_tiff(const PixelImage& image, const std::filesystem::path& file) const override {
        return encode_colour_tiff(image, file);
    }
    std::string depth_tiff(const PixelImage& image, DepthFormat format,
                           const std::filesystem::path& file) const override {
        return encode_depth_tiff(image, format, file);
    }
};

}  // namespace
}  // namespace metabuffer

const metabuffer::ImageCodec* metabuffer_image_module() {
    static const metabuffer::OpenImageIoCodec codec;
    return &codec;
}
