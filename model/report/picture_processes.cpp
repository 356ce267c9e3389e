#include "report/picture_processes.h"

#include <poll.h>

#include <algorithm>
#include <cerrno>
#include <cstdint>
#include <cstring>
#include <utility>

#include "host/child_process.h"
#include "host/message_channel.h"
#include "host/shared_memory.h"

namespace metabuffer {
namespace {

/// What precedes a picture's name in the message to the process.
struct Size {
    std::int32_t width_pixels = 0;
    std::int32_t height_pixels = 0;
};

}  // namespace

/// A process with its memory and its channel.
class PictureProcesses::Worker {
  public:
    Worker(std::size_t most_pixels, const Encode& encode)
        : memory_(most_pixels * sizeof(std::uint32_t)),
          process_([this, &encode](const ChildProcess::Sender& /*pipe*/) { serve(encode); }) {
        channel_.be_parent();
    }

    bool is_busy() const { return is_busy_; }
    bool is_gone() const { return is_gone_; }
    int descriptor() const { return channel_.descriptor(); }

    /// A process that has ended does not receive it, and settle() reports that.
    void hand_over(const std::string& name, const ColourImage& picture) {
        std::copy(picture.values.begin(), picture.values.end(), pixels());
        size_ = {picture.width_pixels, picture.height_pixels};
        std::string message(sizeof size_, '\0');
        std::memcpy(message.data(), &size_, sizeof size_);
        name_ = name;
        is_busy_ = true;
        channel_.send(message + name);
    }
    /// Waits until it is idle. True if its picture is written; false if nothing is known of it. Throws the error that
    /// says why it cannot be written.
    bool settle() {
        const std::string ending = channel_.receive();
        is_busy_ = false;
        is_gone_ = ending.empty();
        return is_done(ending);
    }
    const std::string& name() const { return name_; }
    ColourImage picture() const {
        ColourImage picture(size_.width_pixels, size_.height_pixels);
        std::copy_n(pixels(), picture.values.size(), picture.values.begin());
        return picture;
    }

  private:
    /// What the process does until its parent has ended.
    void serve(const Encode& encode) {
        channel_.be_child();
        // If it fails, its parent tries the same and says why.
        be_silent();
        for (std::string message = channel_.receive(); !message.empty(); message = channel_.receive()) {
            std::memcpy(&size_, message.data(), sizeof size_);
            const std::string ending = ending_of([&] { encode(message.substr(sizeof size_), picture()); });
            if (!channel_.send(ending)) return;
        }
    }

    std::uint32_t* pixels() const { return static_cast<std::uint32_t*>(memory_.begin()); }

    SharedMemory memory_;
    MessageChannel channel_;
    Size size_;         ///< of the last picture
    std::string name_;  ///< of it
    bool is_busy_ = false;
    bool is_gone_ = false;
    ChildProcess process_;
};

PictureProcesses::PictureProcesses(std::size_t processes, std::size_t most_pixels, Encode encode)
    : encode_(std::move(encode)), most_pixels_(most_pixels) {
    try {
        while (workers_.size() < processes)
            workers_.push_back(std::make_unique<Worker>(most_pixels, encode_));
    } catch (const std::exception&) {
        // This computer has no memory or no process for one more: the existing processes do the work, or this one does.
    }
}

PictureProcesses::~PictureProcesses() = default;

void PictureProcesses::take(const std::string& name, const ColourImage& picture) {
    Worker* const worker = picture.values.size() > most_pixels_ ? nullptr : idle_worker();
    if (worker != nullptr) {
        worker->hand_over(name, picture);
    } else {
        encode_(name, picture);
    }
}

void PictureProcesses::finish() {
    for (const auto& worker : workers_) {
        if (worker->is_busy()) settle(*worker);
    }
}

void PictureProcesses::settle(Worker& worker) const {
    if (!worker.settle()) encode_(worker.name(), worker.picture());
}

/// Null if there is no process.
PictureProcesses::Worker* PictureProcesses::idle_worker() {
    while (!workers_.empty()) {
        for (const auto& worker : workers_) {
            if (!worker->is_busy()) return worker.get();
        }
        wait_for_any();
        workers_.erase(std::remove_if(workers_.begin(), workers_.end(),
                                      [](const auto& worker) { return worker->is_gone(); }),
                       workers_.end());
    }
    return nullptr;
}

/// Call it when all are busy.
void PictureProcesses::wait_for_any() {
    constexpr int kForEver = -1;
    std::vector<pollfd> channels;
    for (const auto& worker : workers_) channels.push_back({worker->descriptor(), POLLIN, 0});
    while (poll(channels.data(), channels.size(), kForEver) < 0 && errno == EINTR) {
    }
    for (std::size_t n = 0; n < workers_.size(); ++n) {
        if (channels[n].revents != 0) settle(*workers_[n]);
    }
}

}  // namespace metabuffer
