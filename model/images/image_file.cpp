#include "images/image_file.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstddef>
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

constexpr std::size_t kLookedAtBytes = 12;

struct ImageFormat {
    const char* reader;  ///< OpenImageIO's name
    const char* name;
    bool (*is_begun_by)(std::string_view bytes);
};

bool begins(std::string_view bytes, std::string_view with) { return bytes.substr(0, with.size()) == with; }

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
         return begins(bytes, "RIFF"sv) && bytes.size() >= kLookedAtBytes && bytes.substr(8) == "WEBP"sv;
     }},
    {"hdr", "Radiance HDR", [](std::string_view bytes) { return begins(bytes, "#?"sv); }},
    {"sgi", "SGI", [](std::string_view bytes) { return begins(bytes, "\x01\xda"sv); }},
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

/// The file's first bytes. Says in the system's words why it cannot be opened: the readers' differ from each other.
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

/// OpenImageIO's name of what reads the file, null if nothing does.
const char* reader_of(const std::filesystem::path& file) {
    const std::string bytes = first_bytes(file);
    for (const ImageFormat& format : kFormats) {
        if (format.is_begun_by(bytes)) return format.reader;
    }
    const bool is_targa = std::find(kTargaExtensions.begin(), kTargaExtensions.end(),
                                    file.extension().string()) != kTargaExtensions.end();
    return is_targa ? kTargaReader : nullptr;
}

/// Keeps OpenImageIO and OpenEXR from making threads. A sweep reads images and forks, and the child reads more: there
/// OpenEXR would wait for ever for its threads, which fork() does not take along.
void read_in_this_thread() {
    // OpenEXR has threads of its own, one even for a count of 1; -1 is none. Of the state of the process, not of a
    // scenario: once is enough.
    static const bool done = OIIO::attribute("threads", 1) && OIIO::attribute("exr_threads", -1);
    static_cast<void>(done);
}

}  // namespace

std::unique_ptr<OIIO::ImageInput> open_image_file(const std::filesystem::path& file) {
    const char* reader = reader_of(file);
    if (reader == nullptr) fail_unreadable_image(file, "it begins as none of the formats that are read");
    read_in_this_thread();
    std::unique_ptr<OIIO::ImageInput> input = OIIO::ImageInput::create(reader);
    if (input == nullptr) fail_unreadable_image(file, OIIO::geterror());
    OIIO::ImageSpec spec;
    if (!input->open(file.string(), spec)) fail_unreadable_image(file, input->geterror());
    return input;
}

void fail_image(const std::filesystem::path& file, const std::string& message) {
    throw InputError(text::one_line(file.string() + ": " + message));
}

void fail_unreadable_image(const std::filesystem::path& file, const std::string& why) {
    // Some readers repeat a complaint for each strip of an image.
    constexpr std::size_t kLongestReason = 150;
    const std::string reason = text::one_line(std::string_view(why).substr(0, kLongestReason));
    fail_image(file, "is not a readable image: " + (reason.empty() ? "no reason given" : reason) +
                         "; use an intact " + formats() + " file");
}

}  // namespace metabuffer
