#include "images/image_codec.h"

#include "images/image_service.h"

namespace metabuffer {
namespace {

class ImagesOfCodec final : public ImageSource {
  public:
    ImageSize size(const ImageFiles& files) const override { return image_codec().size(files); }
    ReadImage load(const ImageFiles& files, DepthFormat format, const ImageReading& reading) const override {
        return image_codec().load(files, format, reading);
    }
};

}  // namespace

const ImageCodec& image_codec() {
    static const ImageService service;
    return service;
}

std::shared_ptr<const ImageSource> images_of_codec() { return std::make_shared<const ImagesOfCodec>(); }

}  // namespace metabuffer
