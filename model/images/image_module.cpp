#include "images/image_module.h"

#include "images/image_encoder.h"
#include "images/image_reader.h"

namespace metabuffer {
namespace {

class OpenImageIoCodec final : public ImageCodec {
  public:
    ImageSize size(const ImageFiles& files) const override { return image_size(files); }
    ReadImage load(const ImageFiles& files, DepthFormat format, const ImageReading& reading) const override {
        return load_image(files, format, reading);
    }
    std::string png(const ColourImage& image, const std::filesystem::path& file,
                    const std::string& description) const override {
        return encode_png(image, file, description);
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
