#pragma once

#include <OpenImageIO/imageio.h>

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <memory>
#include <string>
#include <type_traits>
#include <vector>

#include "formats/image.h"
#include "images/image_channels.h"
#include "images/image_file.h"

namespace metabuffer {

/// The display window of an image: the coordinates of its first pixel, and its size.
struct DisplayWindow {
    int x = 0;
    int y = 0;
    ImageSize size;  ///< of the upright image
};

/// Where the samples of a file lie in the upright image. A file has the samples of a data window, which may be larger or
/// smaller than the display window. Samples outside of the display window are left out.
class Placement {
  public:
    /// orientation: as EXIF numbers them, 1 to 8; others count as 1, upright. The windows are those of the file.
    Placement(int orientation, const OIIO::ROI& data, const OIIO::ROI& display);

    ImageSize size() const { return size_; }
    /// Whether every pixel of the image has samples.
    bool covers_all() const { return covers_all_; }

    /// Calls use(sample, index): numbers of a sample in the file, and of its pixel in the image, row by row.
    template <typename Use>
    void for_each(Use use) const {
        for (std::int64_t y = first_y_; y < end_y_; ++y) {
            std::int64_t sample = y * data_width_ + first_x_;
            std::int64_t index = start_ + first_x_ * step_x_ + y * step_y_;
            for (std::int64_t x = first_x_; x < end_x_; ++x, ++sample, index += step_x_) {
                use(static_cast<std::size_t>(sample), static_cast<std::size_t>(index));
            }
        }
    }

  private:
    std::int64_t data_width_;
    std::int64_t first_x_, end_x_, first_y_, end_y_;  ///< samples that are shown, in the data window
    std::int64_t start_, step_x_, step_y_;  ///< the index of sample (x, y): start + x step_x + y step_y
    ImageSize size_;
    bool covers_all_;
};

/// A 16-bit float as its file has it; the standard library has no type for it.
struct Half {
    std::uint16_t bits = 0;
};
double to_double(Half half);
inline double to_double(float value) { return value; }
inline double to_double(double value) { return value; }

/// Samples of some of a file's channels, unconverted.
class NativeSamples {
  public:
    NativeSamples(std::filesystem::path file, OIIO::ImageSpec spec, int first_channel,
                  std::vector<unsigned char> samples, const Placement& placement);

    const Placement& placement() const { return placement_; }
    std::size_t pixels() const;
    /// Whether R, G and B are yet to be multiplied by alpha.
    bool is_unassociated() const { return spec_.get_int_attribute("oiio:UnassociatedAlpha") != 0; }
    /// Whether the file's whole numbers had fewer bits and were scaled up.
    bool has_scaled_integers(int channel) const;

    /// Calls convert(sample, index) for every sample of a channel that has been read and its pixel in the image. A sample
    /// is double for the floating types and the unsigned type itself for the others.
    template <typename Convert>
    void for_each(int channel, Convert convert) const {
        switch (spec_.channelformat(channel).basetype) {
            case OIIO::TypeDesc::UINT8:
                return visit<std::uint8_t>(channel, convert);
            case OIIO::TypeDesc::UINT16:
                return visit<std::uint16_t>(channel, convert);
            case OIIO::TypeDesc::UINT32:
                return visit<std::uint32_t>(channel, convert);
            case OIIO::TypeDesc::HALF:
                return visit<Half>(channel, convert);
            case OIIO::TypeDesc::FLOAT:
                return visit<float>(channel, convert);
            case OIIO::TypeDesc::DOUBLE:
                return visit<double>(channel, convert);
            default:
                fail_for_type(channel);
        }
    }

    [[noreturn]] void fail_at_pixel(int channel, std::size_t index, const std::string& message) const;
    [[noreturn]] void fail(const std::string& message) const { fail_image(file_, message); }

  private:
    std::size_t offset_of(int channel) const;
    [[noreturn]] void fail_for_type(int channel) const;

    template <typename Sample, typename Convert>
    void visit(int channel, Convert& convert) const {
        const unsigned char* const samples = samples_.data() + offset_of(channel);
        placement_.for_each([&](std::size_t number, std::size_t index) {
            Sample sample{};
            std::memcpy(&sample, samples + number * pixel_bytes_, sizeof sample);
            if constexpr (std::is_integral_v<Sample>) {
                convert(sample, index);
            } else {
                convert(to_double(sample), index);
            }
        });
    }

    std::filesystem::path file_;
    OIIO::ImageSpec spec_;
    int first_channel_;
    std::vector<unsigned char> samples_;
    std::size_t pixel_bytes_;
    Placement placement_;
};

/// An open image file.
class NativeImage {
  public:
    /// Throws InputError.
    explicit NativeImage(const std::filesystem::path& file);

    const std::vector<image_channels::Part>& parts() const { return parts_; }
    /// What the part shows. Checks what can be checked before its samples are read. Throws InputError.
    DisplayWindow window(int part) const;
    /// Reads the channels first..last, both included, of a part whose window has been asked for. Throws InputError.
    NativeSamples read(int part, int first, int last);
    [[noreturn]] void fail(const std::string& message) const { fail_image(file_, message); }

  private:
    const OIIO::ImageSpec& spec(int part) const { return specs_[static_cast<std::size_t>(part)]; }
    Placement placement(int part) const;
    void reject_unread_doubles(const OIIO::ImageSpec& spec, int first, int last) const;

    std::filesystem::path file_;
    OpenImageFile open_;
    std::vector<OIIO::ImageSpec> specs_;  ///< by part
    std::vector<image_channels::Part> parts_;
};

}  // namespace metabuffer
