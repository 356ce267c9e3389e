#include "report/picture_processes.h"

#include <poll.h>
#include <sys/mman.h>

#include <algorithm>
#include <cerrno>
#include <cstdint>
#include <cstring>
#include <new>
#include <thread>
#include <utility>

#include "host/child_process.h"
#include "host/message_channel.h"
#include "host/output_file.h"

namespace metabuffer {
namespace {

/// Pixels that a process and its parent share.
class SharedPixels {
  public:
    explicit SharedPixels(std::size_t count) : bytes_(count * sizeof(std::uint32_t)) {
        void* const memory = mmap(nullptr, bytes_, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
        if (memory == MAP_FAILED) throw std::bad_alloc();
        pixels_ = static_cast<std::uint32_t*>(memory);
    }
    SharedPixels(const SharedPixels&) = delete;
    SharedPixels& operator=(const SharedPixels&) = delete;
    ~SharedPixels() { munmap(pixels_, bytes_); }

    std::uint32_t* pixels() const { return pixels_; }

  private:
    std::size_t bytes_;
    std::uint32_t* pixels_ = nullptr;
};

/// What precedes a picture's name in the message that hands it over.
struct Size {
    std::int32_t width_pixels = 0;
    std::int32_t height_pixels = 0;
};

}  // namespace

/// A process with its memory and its channel.
class PictureProcesses::Worker {
  public:
    Worker(std::size_t most_pixels, const Encode& encode)
        : memory_(most_pixels),
          process_([this, &encode](const ChildProcess::Sender& /*pipe*/) { serve(encode); }) {
        channel_.be_parent();
    }

    bool is_busy() const { return !name_.empty(); }
    int descriptor() const { return channel_.descriptor(); }

    void hand_over(const std::string& name, const ColourImage& picture) {
        std::copy(picture.values.begin(), picture.values.end(), memory_.pixels());
        const Size size{picture.width_pixels, picture.height_pixels};
        std::string message(sizeof size, '\0');
        std::memcpy(message.data(), &size, sizeof size);
        name_ = name;
        if (!channel_.send(message + name)) fail();
    }
    /// Waits until the picture is written.
    void settle() {
        const std::string received = channel_.receive();
        if (received.empty()) fail();
        name_.clear();
        throw_if_failed(received);
    }

  private:
    /// What the process does until its parent has gone.
    void serve(const Encode& encode) {
        channel_.be_child();
        for (std::string message = channel_.receive(); !message.empty(); message = channel_.receive()) {
            Size size;
            std::memcpy(&size, message.data(), sizeof size);
            ColourImage picture(size.width_pixels, size.height_pixels);
            std::copy_n(memory_.pixels(), picture.values.size(), picture.values.begin());
            const std::string name = message.substr(sizeof size);
            if (!channel_.send(ending_of([&] { encode(name, picture); }))) return;
        }
    }
    [[noreturn]] void fail() {
        const std::string name = std::exchange(name_, {});
        std::string nothing;
        while (!process_.ended()) process_.receive(nothing);
        const std::string& complaint = process_.complaint();
        fail_to_write(name, "the process that encodes it " +
                                (complaint.empty() ? std::string("ended before it was done") : complaint));
    }

    SharedPixels memory_;
    MessageChannel channel_;
    std::string name_;  ///< of the picture that is being written; empty if none is
    ChildProcess process_;
};

PictureProcesses::PictureProcesses(std::size_t processes, std::size_t most_pixels, Encode encode)
    : encode_(std::move(encode)), most_pixels_(most_pixels) {
    try {
        while (workers_.size() < processes)
            workers_.push_back(std::make_unique<Worker>(most_pixels, encode_));
    } catch (const std::exception&) {
        // This computer has no memory or no process for one more: those that there are do the work, or this one does.
    }
}

PictureProcesses::~PictureProcesses() = default;

void PictureProcesses::take(const std::string& name, const ColourImage& picture) {
    if (workers_.empty() || picture.values.size() > most_pixels_) {
        encode_(name, picture);
    } else {
        idle_worker().hand_over(name, picture);
    }
}

void PictureProcesses::finish() {
    for (const auto& worker : workers_) {
        if (worker->is_busy()) worker->settle();
    }
}

PictureProcesses::Worker& PictureProcesses::idle_worker() {
    const auto is_idle = [](const auto& worker) { return !worker->is_busy(); };
    auto idle = std::find_if(workers_.begin(), workers_.end(), is_idle);
    while (idle == workers_.end()) {
        wait_for_any();
        idle = std::find_if(workers_.begin(), workers_.end(), is_idle);
    }
    return **idle;
}

/// All are busy.
void PictureProcesses::wait_for_any() {
    constexpr int kForEver = -1;
    std::vector<pollfd> channels;
    for (const auto& worker : workers_) channels.push_back({worker->descriptor(), POLLIN, 0});
    while (poll(channels.data(), channels.size(), kForEver) < 0 && errno == EINTR) {
    }
    for (std::size_t n = 0; n < workers_.size(); ++n) {
        if (channels[n].revents != 0) workers_[n]->settle();
    }
}

std::size_t picture_process_count() {
    const unsigned cores = std::thread::hardware_concurrency();
    return cores > 1 ? cores : 0;
}

}  // namespace metabuffer
