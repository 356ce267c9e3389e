#include "images/image_process.h"

#include <unistd.h>

#include <cstdint>
#include <cstring>
#include <optional>
#include <string>
#include <type_traits>
#include <utility>

#include "host/child_process.h"
#include "host/errors.h"
#include "host/message_channel.h"

namespace metabuffer {
namespace {

/// What precedes the two paths in a request. Both processes are the same program, so the layout is the same.
struct Request {
    DepthFormat format{};
    DepthRange range;
    double z = 0.0;
    bool has_depth = false;
    bool has_z = false;
};

constexpr char kBetweenPaths = '\0';

std::string packed(const ImageFiles& files, DepthFormat format, const DepthRange& range) {
    const Request request{format, range, files.z.value_or(0.0), files.depth.has_value(), files.z.has_value()};
    std::string message(sizeof request, '\0');
    std::memcpy(message.data(), &request, sizeof request);
    message += files.image.string();
    if (files.depth) (message += kBetweenPaths) += files.depth->string();
    return message;
}

PixelImage load(const std::string& message) {
    Request request;
    std::memcpy(&request, message.data(), sizeof request);
    const std::string paths = message.substr(sizeof request);
    const std::size_t end = paths.find(kBetweenPaths);
    ImageFiles files{paths.substr(0, end)};
    if (request.has_depth) files.depth = paths.substr(end + 1);
    if (request.has_z) files.z = request.z;
    return image_codec().load(files, request.format, request.range);
}

/// What precedes an image's pixels.
struct Size {
    std::int32_t width_pixels = 0;
    std::int32_t height_pixels = 0;
};

}  // namespace

class ImageProcess::Reader {
  public:
    Reader() : process_([this](const ChildProcess::Sender& pixels) { serve(pixels); }) {
        channel_.be_parent();
    }

    /// Nothing if the process has given no answer. It cannot be used any more then.
    std::optional<PixelImage> load(const std::string& request) {
        if (!channel_.send(request) || !is_done(channel_.receive())) return std::nullopt;
        Size size;
        if (!receive(&size, sizeof size)) return std::nullopt;
        PixelImage image(size.width_pixels, size.height_pixels);
        static_assert(std::is_trivially_copyable_v<Pixel>);
        if (!receive(image.values.data(), image.values.size() * sizeof image.values[0])) return std::nullopt;
        return image;
    }

  private:
    void serve(const ChildProcess::Sender& pixels) const {
        channel_.be_child();
        // If it fails, its parent tries the same and says why.
        be_silent();
        for (std::string request = channel_.receive(); !request.empty(); request = channel_.receive()) {
            PixelImage image;
            const std::string ending = ending_of([&] { image = metabuffer::load(request); });
            if (!channel_.send(ending)) return;
            if (image.values.empty()) continue;
            const Size size{image.width_pixels, image.height_pixels};
            pixels.send(&size, sizeof size);
            pixels.send(image.values.data(), image.values.size() * sizeof image.values[0]);
        }
    }
    bool receive(void* bytes, std::size_t count) {
        while (received_.size() < count) {
            if (process_.ended()) return false;
            process_.receive(received_);
        }
        std::memcpy(bytes, received_.data(), count);
        received_.erase(0, count);
        return true;
    }

    mutable MessageChannel channel_;
    std::string received_;
    ChildProcess process_;
};

/// Null if this computer cannot start the process.
std::unique_ptr<ImageProcess::Reader> ImageProcess::started() {
    try {
        return std::make_unique<Reader>();
    } catch (const InputError&) {
        return nullptr;
    }
}

ImageProcess::ImageProcess() : owner_(getpid()) {}

ImageProcess::~ImageProcess() = default;

PixelImage ImageProcess::load(const ImageFiles& files, DepthFormat format, const DepthRange& range) {
    const std::string request = packed(files, format, range);
    const bool is_here = getpid() != owner_ || reads_here_ || request.size() > MessageChannel::kMostBytes;
    if (is_here) return image_codec().load(files, format, range);
    if (reader_ == nullptr) reader_ = started();
    if (reader_ != nullptr) {
        if (std::optional<PixelImage> image = reader_->load(request)) return *std::move(image);
    }
    reader_.reset();
    reads_here_ = true;
    return image_codec().load(files, format, range);
}

}  // namespace metabuffer
