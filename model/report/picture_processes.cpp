#include "report/picture_processes.h"

#include <poll.h>

#include <algorithm>
#include <cerrno>
#include <cstdint>
#include <cstring>
#include <deque>
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

/// A process with its memory and its channel. The memory is a ring of slots of one picture each.
class PictureProcesses::Worker {
  public:
    Worker(const Extent& extent, const Work& work)
        : slots_(std::max(extent.pictures_each, std::size_t{1})),
          words_of_slot_(1 + extent.pixels_of_largest),
          memory_(slots_ * words_of_slot_ * sizeof(std::uint32_t)),
          process_([this, &work](const ChildProcess::Sender& /*pipe*/) { serve(work); }) {
        channel_.be_parent();
    }

    std::size_t pictures() const { return handed_over_.size(); }
    bool has_room() const { return handed_over_.size() < slots_; }
    bool is_gone() const { return is_gone_; }
    int descriptor() const { return channel_.descriptor(); }

    /// A process that has ended does not receive it, and settle() reports that.
    void hand_over(const std::string& name, const ColourImage& picture) {
        const std::size_t slot = (oldest_slot_ + handed_over_.size()) % slots_;
        std::copy(picture.values.begin(), picture.values.end(), pixels(slot));
        const Size size{picture.width_pixels, picture.height_pixels};
        handed_over_.push_back({name, size});
        std::string message(sizeof size, '\0');
        std::memcpy(message.data(), &size, sizeof size);
        channel_.send(message + name);
    }
    /// Waits for the end of the work on the oldest picture. True if it is done; false if nothing is known of it. Throws
    /// the error that says why it cannot be done. Call drop_oldest() in any case.
    bool settle_oldest() {
        const std::string ending = channel_.receive();
        is_gone_ = ending.empty();
        return is_done(ending);
    }
    void drop_oldest() {
        handed_over_.pop_front();
        oldest_slot_ = (oldest_slot_ + 1) % slots_;
    }

    bool oldest_is_given_back() const { return *given_back(oldest_slot_) != 0; }
    const std::string& name_of_oldest() const { return handed_over_.front().name; }
    ColourImage oldest() const {
        ColourImage picture;
        copy(oldest_slot_, handed_over_.front().size, picture);
        return picture;
    }

  private:
    struct HandedOver {
        std::string name;
        Size size;
    };

    /// What the process does until its parent has ended.
    void serve(const Work& work) {
        channel_.be_child();
        // If it fails, its parent tries the same and says why.
        be_silent();
        std::size_t slot = 0;
        ColourImage picture;  // for all, so that its memory is used again
        for (std::string message = channel_.receive(); !message.empty(); message = channel_.receive()) {
            Size size;
            std::memcpy(&size, message.data(), sizeof size);
            copy(slot, size, picture);
            const std::string ending =
                ending_of([&] { *given_back(slot) = work(message.substr(sizeof size), picture) ? 1 : 0; });
            if (!channel_.send(ending)) return;
            slot = (slot + 1) % slots_;
        }
    }

    std::uint32_t* given_back(std::size_t slot) const {
        return static_cast<std::uint32_t*>(memory_.begin()) + slot * words_of_slot_;
    }
    std::uint32_t* pixels(std::size_t slot) const { return given_back(slot) + 1; }
    void copy(std::size_t slot, const Size& size, ColourImage& picture) const {
        picture.width_pixels = size.width_pixels;
        picture.height_pixels = size.height_pixels;
        const std::size_t count =
            static_cast<std::size_t>(size.width_pixels) * static_cast<std::size_t>(size.height_pixels);
        picture.values.assign(pixels(slot), pixels(slot) + count);
    }

    std::size_t slots_;
    std::size_t words_of_slot_;  ///< whether the picture is given back, and its pixels
    SharedMemory memory_;
    MessageChannel channel_;
    std::deque<HandedOver> handed_over_;  ///< oldest first, in consecutive slots
    std::size_t oldest_slot_ = 0;
    bool is_gone_ = false;
    ChildProcess process_;
};

PictureProcesses::PictureProcesses(const Extent& extent, Work work, GivenBack given_back)
    : work_(std::move(work)),
      given_back_(std::move(given_back)),
      pixels_of_largest_(extent.pixels_of_largest) {
    try {
        while (workers_.size() < extent.processes) {
            workers_.push_back(std::make_unique<Worker>(extent, work_));
        }
    } catch (const std::exception&) {
        // This computer has no memory or no process for one more: the existing processes do the work, or this one does.
    }
}

PictureProcesses::~PictureProcesses() = default;

void PictureProcesses::take(const std::string& name, const ColourImage& picture) {
    Worker* const worker = picture.values.size() > pixels_of_largest_ ? nullptr : worker_with_room();
    if (worker != nullptr) {
        worker->hand_over(name, picture);
    } else {
        do_here(name, picture);
    }
}

void PictureProcesses::finish() {
    for (const auto& worker : workers_) {
        while (worker->pictures() > 0) settle_oldest(*worker);
    }
}

void PictureProcesses::do_here(const std::string& name, const ColourImage& picture) const {
    if (work_(name, picture)) given_back_(name, picture);
}

void PictureProcesses::settle_oldest(Worker& worker) const {
    try {
        if (!worker.settle_oldest()) {
            do_here(worker.name_of_oldest(), worker.oldest());
        } else if (worker.oldest_is_given_back()) {
            given_back_(worker.name_of_oldest(), worker.oldest());
        }
    } catch (...) {
        worker.drop_oldest();
        throw;
    }
    worker.drop_oldest();
}

/// The one with the fewest pictures, or null if there is no process.
PictureProcesses::Worker* PictureProcesses::worker_with_room() {
    while (!workers_.empty()) {
        const auto fewest = std::min_element(
            workers_.begin(), workers_.end(),
            [](const auto& left, const auto& right) { return left->pictures() < right->pictures(); });
        if ((*fewest)->has_room()) return fewest->get();
        wait_for_any();
        for (const auto& worker : workers_) {
            while (worker->is_gone() && worker->pictures() > 0) settle_oldest(*worker);
        }
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
        if (channels[n].revents != 0) settle_oldest(*workers_[n]);
    }
}

}  // namespace metabuffer
