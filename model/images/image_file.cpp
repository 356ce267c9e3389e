#include "images/image_file.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstddef>
#include <cstdint>
#include <fstream>
#include <string_view>
#include <system_error>
#include <vector>

#include "host/errors.h"
#include "host/text.h"
#include "host/text_file.h"

namespace metabuffer {
namespace {

using namespace std::string_view_literals;

/// Up to the end of WebP's canvas size, the last bytes that are checked.
constexpr std::size_t kLookedAtBytes = 30;

struct ImageFormat {
    const char* reader = nullptr;  ///< OpenImageIO's name
    const char* name = nullptr;
    bool (*is_begun_by)(std::string_view bytes) = nullptr;
    /// Refuses what OpenImageIO would accept and should not; may be null.
    void (*check)(const std::filesystem::path& file, std::string_view bytes) = nullptr;
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
void check_webp_canvas(const std::filesystem::path& file, std::string_view bytes) {
    if (bytes.size() < kLookedAtBytes || bytes.substr(8, 8) != "WEBPVP8X"sv) return;
    check_image_size(file, webp_side(bytes.substr(24, 3)), webp_side(bytes.substr(27, 3)));
}

/// OpenImageIO accepts any number of bytes a channel that an SGI file names; with 0 it reads beyond its memory.
void check_sgi_channels(const std::filesystem::path& file, std::string_view bytes) {
    constexpr std::size_t kChannelBytesPlace = 3;
    if (bytes.size() <= kChannelBytesPlace) return;
    const int channel_bytes = static_cast<unsigned char>(bytes[kChannelBytesPlace]);
    if (channel_bytes == 1 || channel_bytes == 2) return;
    fail_unreadable_image(file, "it has " + std::to_string(channel_bytes) + " bytes a channel, not 1 or 2");
}

constexpr std::array<ImageFormat, 8> kFormats{{
    {"png", "PNG", [](std::string_view bytes) { return begins(bytes, "\x89PNG\r\n\x1a\n"sv); }},
    {"openexr", "OpenEXR", [](std::string_view bytes) { return begins(bytes, "\x76\x2f\x31\x01"sv); }},
    {"tiff", "TIFF",
     [](std::string_view bytes) {
         return begins(bytes, "II*\0"sv) || begins(bytes, "MM\0*"sv) || begins(bytes, "II+\0"sv) ||
                begins(bytes, "MM\0+"sv);
     }},
    {"pnm", "PNM",
     [](std::string_view bytes) {
         return bytes.size() > 2 && bytes[0] == 'P' && "123456fF"sv.find(bytes[1]) != std::string_view::npos;
     }},
    {"jpeg", "JPEG", [](std::string_view bytes) { return begins(bytes, "\xff\xd8\xff"sv); }},
    {"webp", "WebP",
     [](std::string_view bytes) {
         return begins(bytes, "RIFF"sv) && bytes.size() > 8 && bytes.substr(8, 4) == "WEBP"sv;
     },
     check_webp_canvas},
    {"hdr", "Radiance HDR", [](std::string_view bytes) { return begins(bytes, "#?"sv); }},
    {"sgi", "SGI", [](std::string_view bytes) { return begins(bytes, "\x01\xda"sv); }, check_sgi_channels},
}};
constexpr const char* kTargaReader = "targa";
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
std::string first_bytes(const std::filesystem::path& file) {
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

bool is_targa(const std::filesystem::path& file) {
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

std::unique_ptr<OIIO::ImageInput> open_image_file(const std::filesystem::path& file) {
    const std::string bytes = first_bytes(file);
    const ImageFormat* const format = format_begun_by(bytes);
    if (format == nullptr && !is_targa(file)) {
        fail_unreadable_image(file, "it begins as none of the formats that are read");
    }
    if (format != nullptr && format->check != nullptr) format->check(file, bytes);
    read_in_this_thread();
    std::unique_ptr<OIIO::ImageInput> input =
        OIIO::ImageInput::create(format != nullptr ? format->reader : kTargaReader);
    if (input == nullptr) fail_unreadable_image(file, OIIO::geterror());
    OIIO::ImageSpec spec;
    const bool opened = ask_reader(file, [&] { return input->open(file.string(), spec); });
    if (!opened) fail_unreadable_image(file, input->geterror());
    return input;
}

void check_image_size(const std::filesystem::path& file, std::int64_t width_pixels,
                      std::int64_t height_pixels) {
    if (kImageSidePixels.contains(width_pixels) && kImageSidePixels.contains(height_pixels)) return;
    fail_image(file, "has " + std::to_string(width_pixels) + " x " + std::to_string(height_pixels) +
                         " pixels; use " + text::range(kImageSidePixels) + " per side");
}

void fail_image(const std::filesystem::path& file, const std::string& message) {
    throw InputError(text::one_line(file.string() + ": " + message));
}

void fail_unreadable_image(const std::filesystem::path& file, const std::string& why) {
    // Some readers repeat a message for each strip of an image.
    constexpr std::size_t kLongestReason = 150;
    const std::string reason = text::one_line(std::string_view(why).substr(0, kLongestReason));
    fail_image(file, "is not a readable image: " + (reason.empty() ? "no reason given" : reason) +
                         "; use an intact " + formats() + " file");
}

}  // namespace metabuffer
