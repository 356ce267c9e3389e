#include "images/image_reader.h"

#include <OpenImageIO/imageio.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <string>
#include <type_traits>
#include <vector>

#include "host/text.h"
#include "images/image_file.h"

namespace metabuffer {
namespace {

constexpr int kNoChannel = -1;

/// A 16-bit float as its file has it; the standard library has no type for it.
struct Half {
    std::uint16_t bits = 0;
};

double to_double(Half half) {
    constexpr int kMantissaBits = 10;
    constexpr int kExponentBias = 15;
    const int exponent = (half.bits >> kMantissaBits) & 0x1F;
    const int mantissa = half.bits & 0x3FF;
    double magnitude = 0.0;
    if (exponent == 0x1F) {
        magnitude = mantissa == 0 ? std::numeric_limits<double>::infinity()
                                  : std::numeric_limits<double>::quiet_NaN();
    } else if (exponent == 0) {
        magnitude = std::ldexp(mantissa, 1 - kExponentBias - kMantissaBits);
    } else {
        magnitude = std::ldexp(mantissa + (1 << kMantissaBits), exponent - kExponentBias - kMantissaBits);
    }
    return (half.bits & 0x8000U) != 0 ? -magnitude : magnitude;
}

double to_double(float value) { return value; }
double to_double(double value) { return value; }

/// clamp(value, 0, 1) * maximum to the nearest whole number, halves up. The product of a float's 24 bits and
/// a maximum of at most 24 is exact in a double.
std::uint32_t scaled(double value, std::uint32_t maximum) {
    return static_cast<std::uint32_t>(std::floor(std::clamp(value, 0.0, 1.0) * maximum + 0.5));
}

/// An open image file, for reading a channel's samples unconverted.
class NativeImage {
  public:
    /// Opens the file and checks what can be checked before its pixels are read.
    explicit NativeImage(const std::filesystem::path& file) : file_(file), input_(open_image_file(file)) {
        spec_ = input_->spec();
        if (spec_.deep || spec_.depth > 1)
            fail_image(file, "is a deep or volume image; use one with flat pixels");
        check_image_size(file, spec_.width, spec_.height);
        if (spec_.image_bytes(true) > kLargestImageBytes) {
            constexpr std::uint64_t kMegabyte = 1'000'000;
            fail_image(file, "holds " + std::to_string(spec_.image_bytes(true) / kMegabyte) + " MB in " +
                                 std::to_string(spec_.nchannels) + " channels; use " +
                                 std::to_string(kLargestImageBytes / kMegabyte) +
                                 " MB or less, with no channels but R, G, B, A and Z");
        }
        // OpenImageIO 2.4 unpacks some of these beyond its memory.
        constexpr int kSeparated = 5;
        if (spec_.get_int_attribute("tiff:PhotometricInterpretation") == kSeparated) {
            fail_image(file, "holds inks (CMYK); use R, G and B");
        }
    }

    int width() const { return spec_.width; }
    int height() const { return spec_.height; }
    int channel_count() const { return spec_.nchannels; }

    int channels_named(const std::string& name) const {
        return static_cast<int>(std::count(spec_.channelnames.begin(), spec_.channelnames.end(), name));
    }
    /// The first channel of that name, kNoChannel if there is none.
    int find_channel(const std::string& name) const {
        const auto found = std::find(spec_.channelnames.begin(), spec_.channelnames.end(), name);
        return found == spec_.channelnames.end() ? kNoChannel
                                                 : static_cast<int>(found - spec_.channelnames.begin());
    }
    std::string channel_list() const { return text::joined(spec_.channelnames, "and"); }

    /// Reads the channels first..last, both included, in the types the file has them in.
    void read(int first, int last) {
        reject_unread_doubles(first, last);
        first_channel_ = first;
        pixel_bytes_ = offset_of(last + 1);
        samples_.resize(pixel_bytes_ * static_cast<std::size_t>(width()) *
                        static_cast<std::size_t>(height()));
        const bool whole = ask_reader(file_, [&] {
            return input_->read_image(0, 0, first, last + 1, OIIO::TypeUnknown, samples_.data());
        });
        // With a strip that cannot be read, the read claims to have worked but leaves an error.
        if (!whole || input_->has_error()) fail_unreadable_image(file_, input_->geterror());
        input_->close();
    }

    /// Calls convert(sample, index) for every pixel of a channel that has been read. Sample is double for the
    /// floating types, never NaN, and the unsigned type itself for the others.
    template <typename Convert>
    void for_each_sample(int channel, Convert convert) const {
        switch (spec_.channelformat(channel).basetype) {
            case OIIO::TypeDesc::UINT8:
                return visit<std::uint8_t>(channel, convert);
            case OIIO::TypeDesc::UINT16:
                return visit<std::uint16_t>(channel, convert);
            case OIIO::TypeDesc::UINT32:
                return visit<std::uint32_t>(channel, convert);
            case OIIO::TypeDesc::UINT64:
                return visit<std::uint64_t>(channel, convert);
            case OIIO::TypeDesc::HALF:
                return visit<Half>(channel, convert);
            case OIIO::TypeDesc::FLOAT:
                return visit<float>(channel, convert);
            case OIIO::TypeDesc::DOUBLE:
                return visit<double>(channel, convert);
            default:
                fail_image(file_, "channel " + name(channel) + " holds " +
                                      spec_.channelformat(channel).c_str() +
                                      " values; use unsigned integers, half, float or double");
        }
    }

    [[noreturn]] void fail_at_pixel(int channel, std::size_t index, const std::string& message) const {
        const std::size_t row = static_cast<std::size_t>(width());
        fail_image(file_, "channel " + name(channel) + " at x " + std::to_string(index % row) + ", y " +
                              std::to_string(index / row) + ": " + message);
    }

  private:
    /// OpenImageIO 2.4 claims to read such files and returns zeros, or nothing at all.
    void reject_unread_doubles(int first, int last) const {
        const bool is_affected =
            std::string(input_->format_name()) == "tiff" && (spec_.tile_width != 0 || spec_.height == 1);
        for (int channel = first; is_affected && channel <= last; ++channel) {
            if (spec_.channelformat(channel).basetype != OIIO::TypeDesc::DOUBLE) continue;
            fail_image(
                file_,
                "channel " + name(channel) +
                    " holds double values in tiles or a single line, which cannot be read from TIFF; use "
                    "float, or strips and two lines or more");
        }
    }

    const std::string& name(int channel) const {
        return spec_.channelnames[static_cast<std::size_t>(channel)];
    }

    std::size_t offset_of(int channel) const {
        std::size_t offset = 0;
        for (int c = first_channel_; c < channel; ++c) offset += spec_.channelformat(c).size();
        return offset;
    }

    template <typename Sample, typename Convert>
    void visit(int channel, Convert& convert) const {
        const std::size_t count = samples_.size() / pixel_bytes_;
        const unsigned char* at = samples_.data() + offset_of(channel);
        for (std::size_t index = 0; index < count; ++index, at += pixel_bytes_) {
            Sample sample{};
            std::memcpy(&sample, at, sizeof sample);
            if constexpr (std::is_integral_v<Sample>) {
                convert(sample, index);
            } else {
                const double value = to_double(sample);
                if (std::isnan(value)) fail_at_pixel(channel, index, "is not a number; use finite values");
                convert(value, index);
            }
        }
    }

    std::filesystem::path file_;
    std::unique_ptr<OIIO::ImageInput> input_;
    OIIO::ImageSpec spec_;
    int first_channel_ = 0;
    std::size_t pixel_bytes_ = 1;
    std::vector<unsigned char> samples_;
};

std::vector<std::uint8_t> colour_channel(const NativeImage& image, int channel) {
    std::vector<std::uint8_t> values(static_cast<std::size_t>(image.width()) *
                                     static_cast<std::size_t>(image.height()));
    image.for_each_sample(channel, [&values](auto sample, std::size_t index) {
        using Sample = decltype(sample);
        if constexpr (std::is_integral_v<Sample>) {
            values[index] = static_cast<std::uint8_t>(sample >> (8 * (sizeof(Sample) - 1)));
        } else {
            values[index] = static_cast<std::uint8_t>(scaled(sample, 255));
        }
    });
    return values;
}

std::vector<std::uint32_t> depth_channel(const NativeImage& image, int channel, DepthFormat format,
                                         const DepthRange& range) {
    const std::uint32_t far = far_z(format);
    std::vector<std::uint32_t> values(static_cast<std::size_t>(image.width()) *
                                      static_cast<std::size_t>(image.height()));
    image.for_each_sample(channel, [&](auto sample, std::size_t index) {
        if constexpr (std::is_integral_v<decltype(sample)>) {
            if (sample > far) {
                image.fail_at_pixel(channel, index,
                                    "Z " + std::to_string(sample) +
                                        " is beyond the far plane of the depth format; use 0 to " +
                                        std::to_string(far) + ", or floats and depth_range");
            }
            values[index] = static_cast<std::uint32_t>(sample);
        } else {
            values[index] = scaled((sample - range.near) / (range.far - range.near), far);
        }
    });
    return values;
}

struct Channels {
    int red = kNoChannel;
    int green = kNoChannel;
    int blue = kNoChannel;
    int depth = kNoChannel;
};

/// The channels of an image. None for depth if it is not in that file.
Channels channels_of(const NativeImage& image, const ImageFiles& files) {
    Channels channels{image.find_channel("R"), image.find_channel("G"), image.find_channel("B"), kNoChannel};
    if (channels.red == kNoChannel || channels.green == kNoChannel || channels.blue == kNoChannel) {
        fail_image(files.image,
                   "has the channels " + image.channel_list() + "; use R, G and B, and A and Z if need be");
    }
    const bool own_depth = !files.depth.has_value() && !files.z.has_value();
    if (own_depth) channels.depth = image.find_channel("Z");
    // Without Z it would be the nearest of all and hide every other image.
    if (own_depth && channels.depth == kNoChannel) {
        fail_image(files.image, "has the channels " + image.channel_list() +
                                    " and no Z; use depth, a file of Z, or z, one depth for all of it");
    }
    return channels;
}

/// The channel of a separate file of Z.
int depth_channel_of(const NativeImage& image, const std::filesystem::path& file, ImageSize size) {
    if (image.width() != size.width_pixels || image.height() != size.height_pixels) {
        fail_image(file, "has " + std::to_string(image.width()) + " x " + std::to_string(image.height()) +
                             " pixels; use " + std::to_string(size.width_pixels) + " x " +
                             std::to_string(size.height_pixels) + ", the size of the image it belongs to");
    }
    if (image.channel_count() == 1) return 0;
    if (image.channels_named("Z") != 1) {
        fail_image(file, "has the channels " + image.channel_list() +
                             "; use one channel, or several with exactly one Z among them");
    }
    return image.find_channel("Z");
}

/// Z from a separate file.
std::vector<std::uint32_t> depth_of_file(const std::filesystem::path& file, ImageSize size,
                                         DepthFormat format, const DepthRange& range) {
    NativeImage image(file);
    const int channel = depth_channel_of(image, file, size);
    image.read(channel, channel);
    return depth_channel(image, channel, format, range);
}

}  // namespace

ImageSize image_size(const ImageFiles& files) {
    const NativeImage image(files.image);
    channels_of(image, files);
    const ImageSize size{image.width(), image.height()};
    if (files.depth.has_value()) depth_channel_of(NativeImage(*files.depth), *files.depth, size);
    return size;
}

PixelImage load_image(const ImageFiles& files, DepthFormat format, const DepthRange& range) {
    NativeImage image(files.image);
    const auto [red, green, blue, depth] = channels_of(image, files);
    // Without alpha on the link, every receiver treats a pixel as opaque.
    const int alpha = layout_of(format).has_alpha() ? image.find_channel("A") : kNoChannel;

    int first = std::min({red, green, blue});
    if (alpha != kNoChannel) first = std::min(first, alpha);
    if (depth != kNoChannel) first = std::min(first, depth);
    image.read(first, std::max({red, green, blue, alpha, depth}));

    PixelImage pixels(image.width(), image.height());
    const std::vector<std::uint8_t> r = colour_channel(image, red);
    const std::vector<std::uint8_t> g = colour_channel(image, green);
    const std::vector<std::uint8_t> b = colour_channel(image, blue);
    const std::vector<std::uint8_t> a = alpha != kNoChannel
                                            ? colour_channel(image, alpha)
                                            : std::vector<std::uint8_t>(pixels.values.size(), 255);
    std::vector<std::uint32_t> z;
    if (files.depth.has_value()) {
        z = depth_of_file(*files.depth, {image.width(), image.height()}, format, range);
    } else if (files.z.has_value()) {
        z.assign(pixels.values.size(),
                 scaled((*files.z - range.near) / (range.far - range.near), far_z(format)));
    } else {
        z = depth_channel(image, depth, format, range);
    }
    for (std::size_t i = 0; i < pixels.values.size(); ++i) {
        pixels.values[i] = Pixel(r[i], g[i], b[i], a[i], z[i]);
    }
    return pixels;
}

}  // namespace metabuffer
