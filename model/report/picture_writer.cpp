#include "report/picture_writer.h"

#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>

#include <algorithm>
#include <cerrno>
#include <cstdint>
#include <fstream>
#include <system_error>

namespace metabuffer {

namespace {

constexpr int kColourChannels = 3;
constexpr std::uint32_t kMidGrey = 0x80'8080U;

/// One line, whatever a library's message looks like.
[[noreturn]] void fail(const std::filesystem::path& file, std::string reason) {
    while (!reason.empty() && reason.back() == '\n') reason.pop_back();
    std::replace(reason.begin(), reason.end(), '\n', ' ');
    throw OutputError("cannot write '" + file.string() + "': " + reason);
}

/// A file that is removed again unless it has been moved to its place.
class TemporaryFile {
  public:
    explicit TemporaryFile(const std::filesystem::path& target) : target_(target), path_(target) {
        path_ += ".part";
    }
    TemporaryFile(const TemporaryFile&) = delete;
    TemporaryFile& operator=(const TemporaryFile&) = delete;
    ~TemporaryFile() {
        std::error_code ignored;
        if (created_ && !moved_) std::filesystem::remove(path_, ignored);
    }

    void write(const char* bytes, std::size_t count) {
        errno = 0;
        std::ofstream stream(path_, std::ios::binary | std::ios::trunc);
        created_ = stream.is_open();
        stream.write(bytes, static_cast<std::streamsize>(count));
        stream.close();
        if (!stream) {
            const int error = errno;
            fail(target_, error != 0 ? std::generic_category().message(error) : "the stream failed");
        }
    }

    void move_to_target() {
        std::error_code error;
        std::filesystem::rename(path_, target_, error);
        if (error) fail(target_, error.message());
        moved_ = true;
    }

  private:
    std::filesystem::path target_;
    std::filesystem::path path_;
    bool created_ = false;
    bool moved_ = false;
};

void write_bytes(const std::filesystem::path& file, const char* bytes, std::size_t count) {
    TemporaryFile temporary(file);
    temporary.write(bytes, count);
    temporary.move_to_target();
}

/// Of 0 to 9. Writing the pictures takes far longer than level tlm takes to make them; higher levels take several
/// times as long again and save little.
constexpr int kPngCompressionLevel = 2;

}  // namespace

// The specification holds geometry alone, no date and no software: the same picture makes the same file.
std::string png_bytes(const ColourImage& image, const std::filesystem::path& file) {
    std::vector<std::uint8_t> channels;
    channels.reserve(image.values.size() * kColourChannels);
    for (const std::uint32_t colour : image.values) {
        channels.push_back(static_cast<std::uint8_t>(colour >> 16));
        channels.push_back(static_cast<std::uint8_t>(colour >> 8));
        channels.push_back(static_cast<std::uint8_t>(colour));
    }

    const auto output = OIIO::ImageOutput::create("png");
    if (output == nullptr) fail(file, OIIO::geterror());
    std::vector<unsigned char> bytes;
    OIIO::Filesystem::IOVecOutput memory(bytes);
    if (!output->set_ioproxy(&memory)) fail(file, "the PNG writer cannot write to memory");
    OIIO::ImageSpec spec(image.width_pixels, image.height_pixels, kColourChannels, OIIO::TypeDesc::UINT8);
    spec.attribute("png:compressionLevel", kPngCompressionLevel);
    if (!output->open(file.string(), spec) || !output->write_image(OIIO::TypeDesc::UINT8, channels.data()) ||
        !output->close()) {
        fail(file, output->geterror());
    }
    return {bytes.begin(), bytes.end()};
}

void write_png(const std::filesystem::path& file, const ColourImage& image) {
    const std::string bytes = png_bytes(image, file);
    write_bytes(file, bytes.data(), bytes.size());
}

void write_text(const std::filesystem::path& file, const std::string& text) {
    write_bytes(file, text.data(), text.size());
}

ColourImage collage(const std::vector<ColourImage>& displays, const DisplayConfig& config, int gap_pixels) {
    const int pitch_x = config.width_pixels + gap_pixels;
    const int pitch_y = config.height_pixels + gap_pixels;
    ColourImage picture(config.columns * pitch_x - gap_pixels, config.rows * pitch_y - gap_pixels, kMidGrey);
    for (std::size_t index = 0; index < displays.size(); ++index) {
        const ColourImage& display = displays[index];
        const int left = static_cast<int>(index) % config.columns * pitch_x;
        const int top = static_cast<int>(index) / config.columns * pitch_y;
        for (int y = 0; y < display.height_pixels; ++y) {
            const auto* row = &display.values[display.index(0, y)];
            std::copy(row, row + display.width_pixels, &picture.values[picture.index(left, top + y)]);
        }
    }
    return picture;
}

}  // namespace metabuffer
