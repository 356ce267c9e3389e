#include "images/native_image.h"

#include <algorithm>
#include <array>
#include <limits>
#include <utility>

#include "host/text.h"

namespace metabuffer {
namespace {

/// How a file's rows and columns lie, after EXIF.
struct Orientation {
    bool flips_x;
    bool flips_y;
    bool swaps;  ///< rows are columns, after the flips
};
constexpr std::array<Orientation, 9> kOrientations{{{false, false, false},  // a number that means nothing
                                                    {false, false, false},
                                                    {true, false, false},
                                                    {true, true, false},
                                                    {false, true, false},
                                                    {false, false, true},
                                                    {false, true, true},
                                                    {true, true, true},
                                                    {true, false, true}}};

}  // namespace

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

// ---- placement ----

Placement::Placement(int orientation, const OIIO::ROI& data, const OIIO::ROI& display)
    : data_width_(data.width()) {
    const bool is_known = orientation > 0 && orientation < static_cast<int>(kOrientations.size());
    const Orientation& lies = kOrientations[static_cast<std::size_t>(is_known ? orientation : 0)];
    const std::int64_t width = display.width();
    const std::int64_t height = display.height();
    const std::int64_t left = std::int64_t{data.xbegin} - display.xbegin;
    const std::int64_t top = std::int64_t{data.ybegin} - display.ybegin;
    first_x_ = std::max<std::int64_t>(0, -left);
    first_y_ = std::max<std::int64_t>(0, -top);
    end_x_ = std::min<std::int64_t>(data.width(), width - left);
    end_y_ = std::min<std::int64_t>(data.height(), height - top);
    covers_all_ = left <= 0 && top <= 0 && left + data.width() >= width && top + data.height() >= height;

    size_ = {static_cast<int>(lies.swaps ? height : width), static_cast<int>(lies.swaps ? width : height)};
    step_x_ = lies.swaps ? size_.width_pixels : 1;
    step_y_ = lies.swaps ? 1 : size_.width_pixels;
    start_ = 0;
    if (lies.flips_x) start_ += (width - 1) * step_x_;
    if (lies.flips_y) start_ += (height - 1) * step_y_;
    if (lies.flips_x) step_x_ = -step_x_;
    if (lies.flips_y) step_y_ = -step_y_;
    start_ += left * step_x_ + top * step_y_;
}

// ---- samples ----

NativeSamples::NativeSamples(std::filesystem::path file, OIIO::ImageSpec spec, int first_channel,
                             std::vector<unsigned char> samples, const Placement& placement)
    : file_(std::move(file)),
      spec_(std::move(spec)),
      first_channel_(first_channel),
      samples_(std::move(samples)),
      pixel_bytes_(samples_.size() / static_cast<std::size_t>(spec_.image_pixels())),
      placement_(placement) {}

std::size_t NativeSamples::pixels() const {
    const ImageSize size = placement_.size();
    return static_cast<std::size_t>(size.width_pixels) * static_cast<std::size_t>(size.height_pixels);
}

bool NativeSamples::has_scaled_integers(int channel) const {
    constexpr int kByteBits = 8;
    const auto bits = static_cast<int>(spec_.get_float_attribute("oiio:BitsPerSample"));
    const bool is_whole = !spec_.channelformat(channel).is_floating_point();
    return is_whole && bits != 0 && bits != static_cast<int>(spec_.channelformat(channel).size()) * kByteBits;
}

std::size_t NativeSamples::offset_of(int channel) const {
    std::size_t offset = 0;
    for (int c = first_channel_; c < channel; ++c) offset += spec_.channelformat(c).size();
    return offset;
}

void NativeSamples::fail_for_type(int channel) const {
    fail("channel " + std::string(spec_.channel_name(channel)) + " holds " +
         spec_.channelformat(channel).c_str() +
         " values; use unsigned integers of up to 32 bits, half, float or double");
}

void NativeSamples::fail_at_pixel(int channel, std::size_t index, const std::string& message) const {
    const auto width = static_cast<std::size_t>(placement_.size().width_pixels);
    fail("channel " + std::string(spec_.channel_name(channel)) + " at x " + std::to_string(index % width) +
         ", y " + std::to_string(index / width) + ": " + message);
}

// ---- file ----

NativeImage::NativeImage(const std::filesystem::path& file) : file_(file), open_(open_image_file(file)) {
    OIIO::ImageInput& input = *open_.input;
    // OpenImageIO 2.4 unpacks some of these beyond its memory.
    constexpr int kSeparated = 5;
    if (input.spec().get_int_attribute("tiff:PhotometricInterpretation") == kSeparated) {
        fail("holds inks (CMYK); use R, G and B");
    }
    do {
        specs_.push_back(input.spec());
        const OIIO::ImageSpec& spec = specs_.back();
        parts_.push_back({spec.get_string_attribute("oiio:subimagename"), spec.channelnames});
    } while (open_.has_parts &&
             ask_reader(file, [&] { return input.seek_subimage(static_cast<int>(specs_.size()), 0); }));
    static_cast<void>(input.geterror());  // that there is no further part
}

Placement NativeImage::placement(int part) const {
    OIIO::ROI data = spec(part).roi();
    OIIO::ROI display = spec(part).roi_full();
    if (open_.windows == OpenImageFile::Windows::kNone)
        data = display = OIIO::ROI(0, data.width(), 0, data.height());
    return {open_.orientation, data, display};
}

DisplayWindow NativeImage::window(int part) const {
    const OIIO::ImageSpec& spec = this->spec(part);
    if (spec.deep || spec.depth > 1) fail("is a deep or volume image; use one with flat pixels");
    const ImageSize size = placement(part).size();
    check_image_size(file_, spec.width, spec.height);
    check_image_size(file_, size.width_pixels, size.height_pixels);
    if (spec.image_bytes(true) > kLargestImageBytes) {
        constexpr std::uint64_t kMegabyte = 1'000'000;
        fail("holds " + std::to_string(spec.image_bytes(true) / kMegabyte) + " MB in " +
             std::to_string(spec.nchannels) + " channels; use " +
             std::to_string(kLargestImageBytes / kMegabyte) +
             " MB or less, with no channels but R, G, B, A and Z");
    }
    const bool has_position = open_.windows == OpenImageFile::Windows::kPositioned;
    return {has_position ? spec.full_x : 0, has_position ? spec.full_y : 0, size};
}

NativeSamples NativeImage::read(int part, int first, int last) {
    const OIIO::ImageSpec& spec = this->spec(part);
    reject_unread_doubles(spec, first, last);
    std::size_t pixel_bytes = 0;
    for (int channel = first; channel <= last; ++channel) pixel_bytes += spec.channelformat(channel).size();
    std::vector<unsigned char> samples(pixel_bytes * static_cast<std::size_t>(spec.image_pixels()));
    OIIO::ImageInput& input = *open_.input;
    const bool whole = ask_reader(
        file_, [&] { return input.read_image(part, 0, first, last + 1, OIIO::TypeUnknown, samples.data()); });
    // With a strip that cannot be read, the read claims to have worked but leaves an error.
    if (!whole || input.has_error()) fail_unreadable_image(file_, input.geterror());
    return {file_, spec, first, std::move(samples), placement(part)};
}

/// OpenImageIO 2.4 claims to read such files and returns zeros, or nothing at all.
void NativeImage::reject_unread_doubles(const OIIO::ImageSpec& spec, int first, int last) const {
    const bool is_affected =
        std::string(open_.input->format_name()) == "tiff" && (spec.tile_width != 0 || spec.height == 1);
    for (int channel = first; is_affected && channel <= last; ++channel) {
        if (spec.channelformat(channel).basetype != OIIO::TypeDesc::DOUBLE) continue;
        fail("channel " + std::string(spec.channel_name(channel)) +
             " holds double values in tiles or a single line, which cannot be read from TIFF; use "
             "float, or strips and two lines or more");
    }
}

}  // namespace metabuffer
