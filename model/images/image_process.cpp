#include "images/image_process.h"

#include <unistd.h>

#include <cstdint>
#include <cstring>
#include <string>
#include <type_traits>
#include <utility>

#include "host/child_process.h"
#include "host/errors.h"
#include "host/message_channel.h"
#include "host/text.h"

namespace metabuffer {
namespace {

/// What precedes the two paths in a request. Both processes are the same program, so the layout is its compiler's.
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

    bool has_ended() const { return process_.ended(); }
    PixelImage load(const ImageFiles& files, const std::string& request) {
        const bool is_sent = channel_.send(request);
        const std::string ending = is_sent ? channel_.receive() : std::string();
        if (ending.empty()) fail(files);
        throw_if_failed(ending);
        Size size;
        receive(files, &size, sizeof size);
        PixelImage image(size.width_pixels, size.height_pixels);
        static_assert(std::is_trivially_copyable_v<Pixel>);
        receive(files, image.values.data(), image.values.size() * sizeof image.values[0]);
        return image;
    }

  private:
    void serve(const ChildProcess::Sender& pixels) const {
        channel_.be_child();
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
    void receive(const ImageFiles& files, void* bytes, std::size_t count) {
        while (received_.size() < count) {
            if (process_.ended()) fail(files);
            process_.receive(received_);
        }
        std::memcpy(bytes, received_.data(), count);
        received_.erase(0, count);
    }
    [[noreturn]] void fail(const ImageFiles& files) {
        while (!process_.ended()) process_.receive(received_);
        const std::string& complaint = process_.complaint();
        throw InputError(
            text::one_line(files.image.string() + ": the process that reads it " +
                           (complaint.empty() ? std::string("ended before it was done") : complaint)));
    }

    mutable MessageChannel channel_;
    std::string received_;
    ChildProcess process_;
};

ImageProcess::ImageProcess() : owner_(getpid()) {}

ImageProcess::~ImageProcess() = default;

PixelImage ImageProcess::load(const ImageFiles& files, DepthFormat format, const DepthRange& range) {
    const std::string request = packed(files, format, range);
    if (getpid() != owner_ || request.size() > MessageChannel::kMostBytes) {
        return image_codec().load(files, format, range);
    }
    if (reader_ == nullptr) {
        try {
            reader_ = std::make_unique<Reader>();
        } catch (const InputError&) {
            // This computer has no process for it.
            return image_codec().load(files, format, range);
        }
    }
    try {
        return reader_->load(files, request);
    } catch (...) {
        if (reader_->has_ended()) reader_.reset();
        throw;
    }
}

}  // namespace metabuffer
