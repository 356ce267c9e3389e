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
#include "images/image_codec.h"

namespace metabuffer {
namespace {

/// What precedes the two paths in a request. Both processes are the same program, so the layout is the same.
struct Request {
    bool wants_pixels = false;
    DepthFormat format{};
    DepthRange range;
    double z = 0.0;
    bool has_depth = false;
    bool has_z = false;
};

constexpr char kBetweenPaths = '\0';

std::string packed(const ImageFiles& files, Request request) {
    request.z = files.z.value_or(0.0);
    request.has_depth = files.depth.has_value();
    request.has_z = files.z.has_value();
    std::string message(sizeof request, '\0');
    std::memcpy(message.data(), &request, sizeof request);
    message += files.image.string();
    if (files.depth) (message += kBetweenPaths) += files.depth->string();
    return message;
}

/// What a request asks for: an image, without pixels if it asks for the size only.
struct Answer {
    ImageSize size;
    PixelImage image;
};

Answer answer(const std::string& message) {
    Request request;
    std::memcpy(&request, message.data(), sizeof request);
    const std::string paths = message.substr(sizeof request);
    const std::size_t end = paths.find(kBetweenPaths);
    ImageFiles files{paths.substr(0, end)};
    if (request.has_depth) files.depth = paths.substr(end + 1);
    if (request.has_z) files.z = request.z;
    if (!request.wants_pixels) return {image_codec().size(files), {}};
    PixelImage image = image_codec().load(files, request.format, request.range);
    return {{image.width_pixels, image.height_pixels}, std::move(image)};
}

}  // namespace

class ImageProcess::Reader {
  public:
    Reader() : process_([this](const ChildProcess::Sender& pixels) { serve(pixels); }) {
        channel_.be_parent();
    }

    /// Nothing if the process has given no answer. It cannot be used any more then.
    std::optional<ImageSize> size(const std::string& request) {
        ImageSize size;
        if (!channel_.send(request) || !is_done(channel_.receive()) || !receive(&size, sizeof size))
            return std::nullopt;
        return size;
    }
    std::optional<PixelImage> load(const std::string& request) {
        const std::optional<ImageSize> size = this->size(request);
        if (!size) return std::nullopt;
        PixelImage image(size->width_pixels, size->height_pixels);
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
            std::optional<Answer> found;
            const std::string ending = ending_of([&] { found = answer(request); });
            if (!channel_.send(ending)) return;
            if (!found) continue;
            pixels.send(&found->size, sizeof found->size);
            pixels.send(found->image.values.data(), found->image.values.size() * sizeof(Pixel));
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

ImageProcess::Reader* ImageProcess::reader() const {
    if (getpid() != owner_ || reads_here_) return nullptr;
    if (reader_ == nullptr) reader_ = started();
    reads_here_ = reader_ == nullptr;
    return reader_.get();
}

void ImageProcess::give_up() const {
    reader_.reset();
    reads_here_ = true;
}

ImageSize ImageProcess::size(const ImageFiles& files) const {
    const std::string request = packed(files, {});
    if (request.size() > MessageChannel::kMostBytes) return image_codec().size(files);
    if (Reader* const process = reader()) {
        if (const std::optional<ImageSize> size = process->size(request)) return *size;
        give_up();
    }
    return image_codec().size(files);
}

PixelImage ImageProcess::load(const ImageFiles& files, DepthFormat format, const DepthRange& range) const {
    Request wanted;
    wanted.wants_pixels = true;
    wanted.format = format;
    wanted.range = range;
    const std::string request = packed(files, wanted);
    if (request.size() > MessageChannel::kMostBytes) return image_codec().load(files, format, range);
    if (Reader* const process = reader()) {
        if (std::optional<PixelImage> image = process->load(request)) return *std::move(image);
        give_up();
    }
    return image_codec().load(files, format, range);
}

}  // namespace metabuffer
