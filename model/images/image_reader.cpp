#include "images/image_reader.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <string>
#include <tuple>
#include <type_traits>
#include <vector>

#include "host/errors.h"
#include "host/text.h"
#include "images/image_channels.h"
#include "images/native_image.h"
#include "images/rescaled.h"

namespace metabuffer {
namespace {

using image_channels::Colours;
using image_channels::Depth;
using image_channels::kNoChannel;

// ---- numbers ----

/// clamp(value, 0, 1) * maximum to the nearest whole number, halves up. The product of a float's 24 bits and
/// a maximum of at most 24 is exact in a double.
std::uint32_t scaled(double value, std::uint32_t maximum) {
    return static_cast<std::uint32_t>(std::floor(std::clamp(value, 0.0, 1.0) * maximum + 0.5));
}

/// The display's value of a linear one, both 0 to 1 (IEC 61966-2-1).
double srgb_curve(double linear) {
    return linear <= 0.0031308 ? 12.92 * linear : 1.055 * std::pow(linear, 1.0 / 2.4) - 0.055;
}

std::string described(const DisplayWindow& window) {
    const auto& [x, y, size] = window;
    return std::to_string(size.width_pixels) + " x " + std::to_string(size.height_pixels) + " pixels" +
           (x == 0 && y == 0 ? "" : " from x " + std::to_string(x) + ", y " + std::to_string(y));
}

// ---- the channels that count ----

/// What InputErrors of image_channels do not say: which file.
template <typename Find>
auto found_in(const NativeImage& image, Find find) {
    try {
        return find(image.parts());
    } catch (const InputError& error) {
        image.fail(error.what());
    }
}

/// An image's files, what they show and where. Of a separate file of Z the headers are read first.
class ImagePlan {
  public:
    explicit ImagePlan(const ImageFiles& files)
        : image(files.image),
          colours(found_in(
              image, [&](const auto& parts) { return image_channels::find_colours(parts, files.layer); })),
          window(image.window(colours.part)) {
        if (files.z) return;
        if (files.depth) depth_image.emplace(*files.depth);
        depth = found_in(depth_file(), [&](const auto& parts) {
            return files.depth ? image_channels::find_depth_alone(parts, files.depth_layer)
                               : image_channels::find_depth(parts, files.depth_layer, colours);
        });
        const DisplayWindow of_depth = depth_file().window(depth.part);
        const bool agrees = of_depth.size.width_pixels == window.size.width_pixels &&
                            of_depth.size.height_pixels == window.size.height_pixels &&
                            of_depth.x == window.x && of_depth.y == window.y;
        if (!agrees) {
            depth_file().fail("has " + described(of_depth) + "; use " + described(window) +
                              (files.depth ? ", as the image it belongs to" : ", as the colours"));
        }
    }

    NativeImage& depth_file() { return depth_image ? *depth_image : image; }

    NativeImage image;
    Colours colours;
    DisplayWindow window;
    Depth depth;
    std::optional<NativeImage> depth_image;  ///< a separate file
};

// ---- colours ----

/// A channel of a pixel's byte, for all of the image; 0 where the file has nothing.
using Bytes = std::vector<std::uint8_t>;
/// Alpha from 0 to 1 that colours are to be multiplied by; empty if they are already.
using Alpha = std::vector<double>;

/// The share of its type's full scale.
template <typename Sample>
double share(Sample sample) {
    if constexpr (std::is_integral_v<Sample>) {
        return static_cast<double>(sample) / std::numeric_limits<Sample>::max();
    } else {
        return sample;
    }
}

Alpha alpha_to_multiply_by(const NativeSamples& samples, int channel) {
    if (channel == kNoChannel || !samples.is_unassociated()) return {};
    Alpha alpha(samples.pixels());
    samples.for_each(channel, [&alpha](auto sample, std::size_t index) {
        alpha[index] = std::clamp(share(sample), 0.0, 1.0);
    });
    return alpha;
}

Bytes bytes_of(const NativeSamples& samples, int channel, const Alpha& alpha, ColourEncoding encoding) {
    constexpr std::uint32_t kFull = 255;
    Bytes bytes(samples.pixels());
    samples.for_each(channel, [&](auto sample, std::size_t index) {
        using Sample = decltype(sample);
        std::uint32_t byte = 0;
        if constexpr (std::is_integral_v<Sample>) {
            byte = alpha.empty() ? rescaled(sample, std::numeric_limits<Sample>::max(), kFull)
                                 : scaled(share(sample) * alpha[index], kFull);
        } else {
            if (std::isnan(sample)) {
                samples.fail_at_pixel(channel, index, "is not a number; use finite values");
            }
            const double value = alpha.empty() ? sample : sample * alpha[index];
            byte = scaled(encoding == ColourEncoding::kSrgb ? srgb_curve(value) : value, kFull);
        }
        bytes[index] = static_cast<std::uint8_t>(byte);
    });
    return bytes;
}

/// Where the file has samples; empty if everywhere.
std::vector<bool> covered(const NativeSamples& samples) {
    if (samples.placement().covers_all()) return {};
    std::vector<bool> is_covered(samples.pixels());
    samples.placement().for_each(
        [&](std::size_t /*sample*/, std::size_t index) { is_covered[index] = true; });
    return is_covered;
}

// ---- Z ----

/// Makes Z of samples, and counts those outside of the depth range.
class DepthConverter {
  public:
    DepthConverter(DepthFormat format, const ImageReading& reading)
        : reading_(reading), far_(far_z(format)), range_(reading.far - reading.near) {}

    std::uint32_t far() const { return far_; }
    const ClampedDepths& clamped() const { return clamped_; }

    /// Of a finite depth in the depth range.
    std::uint32_t of_depth(double depth) const { return scaled((depth - reading_.near) / range_, far_); }

    /// Nothing if the sample is not a number and that does not mean anything.
    std::optional<std::uint32_t> of_sample(double sample) {
        if (is_nothing(sample)) return far_;
        if (std::isnan(sample)) return std::nullopt;
        const double share = (sample - reading_.near) / range_;
        if (share < 0.0) count_before_near(sample);
        if (share < 1.0) ++depths_;
        if (share > 1.0) ++clamped_.behind_far_pixels;
        return scaled(share, far_);
    }

    /// Of a whole number; nothing if it is taken as it is and lies beyond the far plane.
    std::optional<std::uint32_t> of_number(std::uint32_t number, std::uint32_t full) const {
        if (is_nothing(number)) return far_;
        const bool is_raw = reading_.integers == DepthIntegers::kRaw;
        if (is_raw && number > far_) return std::nullopt;
        const std::uint32_t z = is_raw ? number : rescaled(number, full, far_);
        return reading_.larger_is_nearer() ? far_ - z : z;
    }

    /// What is wrong if most depths lie before near: then depth_range does not fit; empty if nothing is.
    std::string complaint() const {
        if (clamped_.before_near_pixels * 2 <= depths_) return "";
        return std::to_string(clamped_.before_near_pixels) + " of its " + text::counted(depths_, "pixel") +
               " that are not far have a depth before near, " + text::number(reading_.near) + ", such as " +
               text::number(first_before_near_) +
               "; use a depth_range with them in it, or depth_nothing if they mean that nothing is there";
    }

  private:
    bool is_nothing(double sample) const {
        if (std::isnan(sample)) return reading_.nan_is_nothing;
        return std::any_of(reading_.nothing.begin(), reading_.nothing.end(), [sample](double nothing) {
            return sample == nothing || sample == static_cast<double>(static_cast<float>(nothing));
        });
    }
    void count_before_near(double sample) {
        if (clamped_.before_near_pixels == 0) first_before_near_ = sample;
        ++clamped_.before_near_pixels;
    }

    const ImageReading& reading_;
    std::uint32_t far_;
    double range_;
    std::int64_t depths_ = 0;  ///< that are not far
    double first_before_near_ = 0.0;
    ClampedDepths clamped_;
};

using Depths = std::vector<std::uint32_t>;

/// Z of a whole number. Throws InputError if it is taken as it is and lies beyond the far plane.
std::uint32_t z_of_number(const NativeSamples& samples, int channel, std::size_t index, std::uint32_t number,
                          std::uint32_t full, const DepthConverter& converter) {
    const std::optional<std::uint32_t> z = converter.of_number(number, full);
    if (!z) {
        samples.fail_at_pixel(channel, index,
                              "Z " + std::to_string(number) +
                                  " is beyond the far plane of the depth format; use 0 to " +
                                  std::to_string(converter.far()) + ", or depth_integers: scaled");
    }
    return *z;
}

/// Far where the file has nothing.
Depths depths_of_channel(const NativeSamples& samples, int channel, DepthConverter& converter,
                         const ImageReading& reading) {
    if (reading.integers == DepthIntegers::kRaw && samples.has_scaled_integers(channel)) {
        samples.fail(
            "has whole numbers of another width than 8, 16 or 32 bits, which are read scaled; "
            "use depth_integers: scaled");
    }
    Depths depths(samples.pixels(), converter.far());
    samples.for_each(channel, [&](auto sample, std::size_t index) {
        using Sample = decltype(sample);
        if constexpr (std::is_integral_v<Sample>) {
            constexpr std::uint32_t kFull = std::numeric_limits<Sample>::max();
            depths[index] = z_of_number(samples, channel, index, sample, kFull, converter);
        } else {
            const std::optional<std::uint32_t> z = converter.of_sample(sample);
            if (!z) {
                samples.fail_at_pixel(channel, index,
                                      "is not a number; use finite values, or depth_nothing: [nan]");
            }
            depths[index] = *z;
        }
    });
    return depths;
}

constexpr int kByteBits = 8;

/// R, G and B, 8 bits each, as one number of 24.
Depths packed_depths(const NativeSamples& samples, const Colours& channels, const DepthConverter& converter) {
    constexpr std::uint32_t kFull = 0xFF'FFFF;
    Depths numbers(samples.pixels());
    for (const int channel : {channels.red, channels.green, channels.blue}) {
        samples.for_each(channel, [&](auto sample, std::size_t index) {
            if constexpr (std::is_same_v<decltype(sample), std::uint8_t>) {
                numbers[index] = numbers[index] << kByteBits | sample;
            } else {
                samples.fail("has R, G and B that are not of 8 bits; depth_bits: rgb24 needs 8");
            }
        });
    }
    Depths depths(samples.pixels(), converter.far());
    samples.placement().for_each([&](std::size_t /*sample*/, std::size_t index) {
        depths[index] = z_of_number(samples, channels.red, index, numbers[index], kFull, converter);
    });
    return depths;
}

/// Throws InputError unless R, G and B are the same everywhere.
void check_is_grey(const NativeSamples& samples, const Colours& channels) {
    std::vector<double> red(samples.pixels());
    samples.for_each(channels.red, [&](auto sample, std::size_t index) { red[index] = sample; });
    for (const int channel : {channels.green, channels.blue}) {
        samples.for_each(channel, [&](auto sample, std::size_t index) {
            const double value = sample;
            if (value == red[index] || (std::isnan(value) && std::isnan(red[index]))) return;
            samples.fail_at_pixel(channel, index,
                                  "differs from R; use a file of Z with the same in R, G and B, depth_bits: "
                                  "rgb24 if they hold 24 bits, or depth_layer");
        });
    }
}

Depths depths_of(const NativeSamples& samples, const Depth& depth, DepthConverter& converter,
                 const ImageReading& reading) {
    if (!depth.colours) return depths_of_channel(samples, depth.channel, converter, reading);
    if (reading.bits == DepthBits::kRgb24) return packed_depths(samples, *depth.colours, converter);
    check_is_grey(samples, *depth.colours);
    return depths_of_channel(samples, depth.channel, converter, reading);
}

/// Z of one file, or of another part of the image's.
Depths separate_depths(ImagePlan& plan, DepthConverter& converter, const ImageReading& reading) {
    const Depth& depth = plan.depth;
    if (plan.depth_image && !depth.colours && reading.bits == DepthBits::kRgb24) {
        plan.depth_file().fail("has no R, G and B that hold Z; depth_bits: rgb24 needs them");
    }
    int first = depth.channel;
    int last = depth.channel;
    if (depth.colours) {
        std::tie(first, last) = std::minmax({depth.colours->red, depth.colours->green, depth.colours->blue});
    }
    return depths_of(plan.depth_file().read(depth.part, first, last), depth, converter, reading);
}

}  // namespace

ImageSize image_size(const ImageFiles& files) { return ImagePlan(files).window.size; }

ReadImage load_image(const ImageFiles& files, DepthFormat format, const ImageReading& reading) {
    ImagePlan plan(files);
    const Colours& channels = plan.colours;
    const bool is_depth_inside = !files.z && !plan.depth_image && plan.depth.part == channels.part;

    std::vector<int> wanted{channels.red, channels.green, channels.blue};
    if (channels.alpha != kNoChannel) wanted.push_back(channels.alpha);
    if (is_depth_inside) wanted.push_back(plan.depth.channel);
    const auto [first, last] = std::minmax_element(wanted.begin(), wanted.end());
    const NativeSamples samples = plan.image.read(channels.part, *first, *last);

    const Alpha alpha = alpha_to_multiply_by(samples, channels.alpha);
    const bool is_grey = channels.red == channels.green;
    const Bytes red = bytes_of(samples, channels.red, alpha, reading.colours);
    const Bytes green = is_grey ? red : bytes_of(samples, channels.green, alpha, reading.colours);
    const Bytes blue = is_grey ? red : bytes_of(samples, channels.blue, alpha, reading.colours);
    // Without alpha on the link, every receiver treats a pixel as opaque.
    const bool sends_alpha = layout_of(format).has_alpha();
    const Bytes opacity = sends_alpha && channels.alpha != kNoChannel
                              ? bytes_of(samples, channels.alpha, {}, ColourEncoding::kAsIs)
                              : Bytes(samples.pixels(), 255);

    DepthConverter converter(format, reading);
    Depths depths;
    if (files.z) {
        depths.assign(samples.pixels(), converter.of_depth(*files.z));
    } else if (is_depth_inside) {
        depths = depths_of(samples, plan.depth, converter, reading);
    } else {
        depths = separate_depths(plan, converter, reading);
    }
    if (const std::string complaint = converter.complaint(); !complaint.empty()) {
        plan.depth_file().fail(complaint);
    }

    const std::vector<bool> is_covered = covered(samples);
    const Pixel nothing(0, 0, 0, sends_alpha ? 0 : 255, converter.far());
    ReadImage pixels{PixelImage(plan.window.size.width_pixels, plan.window.size.height_pixels)};
    pixels.clamped = converter.clamped();
    for (std::size_t i = 0; i < pixels.values.size(); ++i) {
        pixels.values[i] = is_covered.empty() || is_covered[i]
                               ? Pixel(red[i], green[i], blue[i], opacity[i], depths[i])
                               : nothing;
    }
    return pixels;
}

}  // namespace metabuffer
