#pragma once

#include <chrono>
#include <exception>
#include <functional>
#include <optional>

#include "formats/image.h"

namespace metabuffer {

/// A renderer's image of known size. Its pixels are read from their file when they are first needed, and kept. Not for
/// two threads at the same time.
class StoredImage {
  public:
    /// Reads the pixels. What it throws reaches the caller of pixels().
    using Read = std::function<ReadImage()>;

    /// An image in memory.
    explicit StoredImage(PixelImage pixels);
    StoredImage(ImageSize size, Read read);

    int width_pixels() const { return size_.width_pixels; }
    int height_pixels() const { return size_.height_pixels; }

    /// Throws what `read` throws.
    const PixelImage& pixels() const {
        if (!pixels_) read_pixels();
        return *pixels_;
    }
    /// Reads the pixels without keeping them. Throws what `read` throws. Not for an image in memory.
    ReadImage read() const { return read_(); }
    /// Gives the pixels' memory back. They are read again if they are needed; an image in memory is needed no more.
    void forget() const { pixels_.reset(); }
    /// Whether the pixels are in memory.
    bool is_read() const { return pixels_.has_value(); }
    /// Depths outside of the depth range; none before the image is read.
    const ClampedDepths& clamped() const { return clamped_; }
    /// The wall time that pixels() took to read the image; 0 if it has not read it.
    std::chrono::duration<double> reading_time() const { return reading_time_; }
    /// What the last reading has thrown; null if it has thrown nothing. A simulation's kernel wraps what passes through
    /// it, so its caller finds the original here.
    std::exception_ptr failure() const { return failure_; }

  private:
    void read_pixels() const;

    ImageSize size_;
    Read read_;
    mutable std::optional<PixelImage> pixels_;
    mutable ClampedDepths clamped_;
    mutable std::chrono::duration<double> reading_time_{};
    mutable std::exception_ptr failure_;
};

}  // namespace metabuffer
