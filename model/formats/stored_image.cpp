#include "formats/stored_image.h"

#include <utility>

namespace metabuffer {

StoredImage::StoredImage(PixelImage pixels)
    : size_{pixels.width_pixels, pixels.height_pixels}, pixels_(std::move(pixels)) {}

StoredImage::StoredImage(ImageSize size, Read read) : size_(size), read_(std::move(read)) {}

void StoredImage::read_pixels() const {
    using Clock = std::chrono::steady_clock;
    failure_ = nullptr;
    const Clock::time_point begun = Clock::now();
    try {
        ReadImage image = read_();
        clamped_ = image.clamped;
        pixels_ = std::move(image);
        reading_time_ = Clock::now() - begun;
    } catch (...) {
        failure_ = std::current_exception();
        throw;
    }
}

}  // namespace metabuffer
