#include "images/image_file.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <fstream>
#include <iomanip>
#include <limits>
#include <string_view>
#include <system_error>
#include <vector>

#include "host/errors.h"
#include "host/text.h"
#include "host/text_file.h"

// Its header, tiffutils.h, includes one of libtiff, which need not be installed.
OIIO_NAMESPACE_BEGIN
OIIO_API bool decode_exif(string_view exif, ImageSpec& spec);
OIIO_NAMESPACE_END

namespace metabuffer {
namespace {

using namespace std::string_view_literals;

/// Up to the end of WebP's canvas size, the last bytes that are checked.
constexpr std::size_t kLookedAtBytes = 30;

using Path = std::filesystem::path;

struct ImageFormat {
    const char* reader = nullptr;  ///< OpenImageIO's name
    const char* name = nullptr;
    bool (*is_begun_by)(std::string_view bytes) = nullptr;
    /// Refuses what OpenImageIO would accept and should not; may be null.
    void (*check)(const Path& file, std::string_view bytes) = nullptr;
    /// As EXIF numbers them, if OpenImageIO does not know or has it wrong; may be null.
    int (*orientation)(const Path& file, int of_reader) = nullptr;
    OpenImageFile::Windows windows = OpenImageFile::Windows::kNone;
    bool has_parts = false;
};

bool begins(std::string_view bytes, std::string_view with) { return bytes.substr(0, with.size()) == with; }

/// Three bytes, the lowest first, hold one less than a side.
std::int64_t webp_side(std::string_view bytes) {
    std::int64_t side = 0;
    for (auto byte = bytes.rbegin(); byte != bytes.rend(); ++byte)
        side = side * 256 + static_cast<unsigned char>(*byte);
    return side + 1;
}

/// OpenImageIO allocates all of a WebP file's canvas when it opens the file, before its size can be checked: up to 16
/// TB for a file of 100 bytes. Only the extended form can say more than 16383 pixels a side.
void check_webp_canvas(const Path& file, std::string_view bytes) {
    if (bytes.size() < kLookedAtBytes || bytes.substr(8, 8) != "WEBPVP8X"sv) return;
    check_image_size(file, webp_side(bytes.substr(24, 3)), webp_side(bytes.substr(27, 3)));
}

/// OpenImageIO accepts any number of bytes a channel that an SGI file names; with 0 it reads beyond its memory.
void check_sgi_channels(const Path& file, std::string_view bytes) {
    constexpr std::size_t kChannelBytesOffset = 3;
    if (bytes.size() <= kChannelBytesOffset) return;
    const int channel_bytes = static_cast<unsigned char>(bytes[kChannelBytesOffset]);
    if (channel_bytes == 1 || channel_bytes == 2) return;
    fail_unreadable_image(file, "it has " + std::to_string(channel_bytes) + " bytes a channel, not 1 or 2");
}

/// OpenImageIO takes one byte of white space for the end of a header. With two, CR and LF, all samples would be in the
/// the wrong offset.
void check_pnm_header(const Path& file, std::string_view bytes) {
    if (bytes.size() < 2 || "456fF"sv.find(bytes[1]) == std::string_view::npos) return;  // samples in words
    std::ifstream input(file, std::ios::binary);
    input.ignore(2);
    std::vector<std::int64_t> numbers;
    const std::size_t count = bytes[1] == '4' ? 2 : 3;
    constexpr int kLongestWord = 32;
    constexpr long long kMostPixels = 65536;  // a side: more is refused anyway
    for (std::string word; numbers.size() < count && input >> std::setw(kLongestWord) >> word;) {
        if (word.front() == '#') {
            input.ignore(std::numeric_limits<std::streamsize>::max(), '\n');
        } else {
            numbers.push_back(std::clamp(std::strtoll(word.c_str(), nullptr, 10), 0LL, kMostPixels));
        }
    }
    if (numbers.size() < count || input.get() != '\r' || input.get() != '\n') return;
    // A sample may be 10 and look like LF.
    const std::int64_t row = bytes[1] == '4' ? (numbers[0] + 7) / 8 : numbers[0];
    std::int64_t sample_bytes = bytes[1] == '6' || bytes[1] == 'F' ? 3 : 1;
    if (bytes[1] == 'f' || bytes[1] == 'F') sample_bytes *= 4;
    if ((bytes[1] == '5' || bytes[1] == '6') && numbers[2] > 255) sample_bytes *= 2;
    const std::int64_t first_sample = input.tellg() - std::streamoff{1};
    input.seekg(0, std::ios::end);
    if (input.tellg() - std::streampos(first_sample) == row * numbers[1] * sample_bytes) return;
    fail_image(file, "has a header whose lines end in CR and LF; write it with LF alone");
}

/// OpenImageIO leaves EXIF out. It is in one of the chunks of the extended form.
int webp_orientation(const Path& file, int of_reader) {
    constexpr std::size_t kMostExifBytes = 65536;
    std::ifstream input(file, std::ios::binary);
    input.ignore(12);
    for (std::array<char, 8> head{}; input.read(head.data(), head.size());) {
        std::size_t size = 0;
        for (std::size_t n = head.size(); n-- > 4;) size = size * 256 + static_cast<unsigned char>(head[n]);
        if (std::string_view(head.data(), 4) != "EXIF"sv) {
            input.ignore(static_cast<std::streamsize>(size + size % 2));
            continue;
        }
        std::string exif(std::min(size, kMostExifBytes), '\0');
        OIIO::ImageSpec spec;
        if (input.read(exif.data(), static_cast<std::streamsize>(exif.size())) &&
            OIIO::decode_exif(OIIO::string_view(exif), spec)) {
            return spec.get_int_attribute("Orientation", of_reader);
        }
    }
    return of_reader;
}

/// OpenImageIO has two of the eight the wrong way round: columns from the right, their pixels from the top, and columns
/// from the left, their pixels from the bottom.
int radiance_orientation(const Path& /*file*/, int of_reader) {
    constexpr int kFromRight = 6;
    constexpr int kFromBottom = 8;
    if (of_reader == kFromRight) return kFromBottom;
    return of_reader == kFromBottom ? kFromRight : of_reader;
}

/// In the order of ImageFormat's members.
constexpr std::array<ImageFormat, 8> kFormats{{
    {"png", "PNG", [](std::string_view bytes) { return begins(bytes, "\x89PNG\r\n\x1a\n"sv); }},
    {"openexr", "OpenEXR", [](std::string_view bytes) { return begins(bytes, "\x76\x2f\x31\x01"sv); },
     nullptr, nullptr, OpenImageFile::Windows::kPositioned, true},
    {"tiff", "TIFF",
     [](std::string_view bytes) {
         return begins(bytes, "II*\0"sv) || begins(bytes, "MM\0*"sv) || begins(bytes, "II+\0"sv) ||
                begins(bytes, "MM\0+"sv);
     },
     nullptr, nullptr, OpenImageFile::Windows::kSized},
    {"pnm", "PNM",
     [](std::string_view bytes) {
         return bytes.size() > 2 && bytes[0] == 'P' && "123456fF"sv.find(bytes[1]) != std::string_view::npos;
     },
     check_pnm_header},
    {"jpeg", "JPEG", [](std::string_view bytes) { return begins(bytes, "\xff\xd8\xff"sv); }},
    {"webp", "WebP",
     [](std::string_view bytes) {
         return begins(bytes, "RIFF"sv) && bytes.size() > 8 && bytes.substr(8, 4) == "WEBP"sv;
     },
     check_webp_canvas, webp_orientation},
    {"hdr", "Radiance HDR", [](std::string_view bytes) { return begins(bytes, "#?"sv); }, nullptr,
     radiance_orientation},
    {"sgi", "SGI", [](std::string_view bytes) { return begins(bytes, "\x01\xda"sv); }, check_sgi_channels},
}};
constexpr ImageFormat kTarga{"targa", "Targa"};
constexpr std::array<const char*, 2> kTargaExtensions{".tga", ".TGA"};

std::string formats() {
    std::vector<std::string> names;
    names.reserve(kFormats.size() + 1);
    for (const ImageFormat& format : kFormats) names.emplace_back(format.name);
    names.emplace_back("Targa (.tga)");
    return text::joined(names, "or");
}

/// The file's first bytes. If it cannot be opened, the error has the system's message: the readers' messages differ
/// from each other.
std::string first_bytes(const Path& file) {
    input::check_is_regular_file(file);
    errno = 0;
    std::ifstream input(file, std::ios::binary);
    if (!input)
        fail_image(file, "cannot be read: " + std::generic_category().message(errno == 0 ? EIO : errno));
    std::string bytes(kLookedAtBytes, '\0');
    input.read(bytes.data(), static_cast<std::streamsize>(bytes.size()));
    bytes.resize(static_cast<std::size_t>(input.gcount()));
    return bytes;
}

/// The format that begins with the bytes; null if none does.
const ImageFormat* format_begun_by(std::string_view bytes) {
    const auto* const format = std::find_if(
        kFormats.begin(), kFormats.end(), [bytes](const ImageFormat& one) { return one.is_begun_by(bytes); });
    return format != kFormats.end() ? format : nullptr;
}

bool is_targa(const Path& file) {
    return std::find(kTargaExtensions.begin(), kTargaExtensions.end(), file.extension().string()) !=
           kTargaExtensions.end();
}

/// Keeps OpenImageIO and OpenEXR from making threads. A sweep reads images and forks, and the child reads more: there
/// OpenEXR would wait for ever for its threads, which fork() does not copy.
void read_in_this_thread() {
    // OpenEXR has threads of its own, one even for a count of 1; -1 means none. This is a setting of the process, not
    // of a scenario: once is enough.
    static const bool done = OIIO::attribute("threads", 1) && OIIO::attribute("exr_threads", -1);
    static_cast<void>(done);
}

}  // namespace

OpenImageFile open_image_file(const Path& file) {
    const std::string bytes = first_bytes(file);
    const ImageFormat* format = format_begun_by(bytes);
    if (format == nullptr && is_targa(file)) format = &kTarga;
    if (format == nullptr) fail_unreadable_image(file, "it begins as none of the formats that are read");
    if (format->check != nullptr) format->check(file, bytes);
    read_in_this_thread();
    OpenImageFile open;
    open.input = OIIO::ImageInput::create(format->reader);
    if (open.input == nullptr) fail_unreadable_image(file, OIIO::geterror());
    // OpenImageIO 2.4 has its own way to multiply colours by alpha for each format, wrong if a PNG file has a gamma.
    OIIO::ImageSpec unassociated;
    unassociated.attribute("oiio:UnassociatedAlpha", 1);
    OIIO::ImageSpec spec;
    const bool opened = ask_reader(file, [&] { return open.input->open(file.string(), spec, unassociated); });
    if (!opened) fail_unreadable_image(file, open.input->geterror());
    const int of_reader = spec.get_int_attribute("Orientation", 1);
    open.orientation = format->orientation == nullptr ? of_reader : format->orientation(file, of_reader);
    open.windows = format->windows;
    open.has_parts = format->has_parts;
    return open;
}

void check_image_size(const Path& file, std::int64_t width_pixels, std::int64_t height_pixels) {
    if (kImageSidePixels.contains(width_pixels) && kImageSidePixels.contains(height_pixels)) return;
    fail_image(file, "has " + std::to_string(width_pixels) + " x " + std::to_string(height_pixels) +
                         " pixels; use " + text::range(kImageSidePixels) + " per side");
}

void fail_image(const Path& file, const std::string& message) {
    throw InputError(text::one_line(file.string() + ": " + message));
}

void fail_unreadable_image(const Path& file, const std::string& why) {
    // Some readers repeat a message for each strip of an image.
    constexpr std::size_t kLongestReason = 150;
    const std::string reason = text::one_line(std::string_view(why).substr(0, kLongestReason));
    fail_image(file, "is not a readable image: " + (reason.empty() ? "no reason given" : reason) +
                         "; use an intact " + formats() + " file");
}

}  // namespace metabuffer
