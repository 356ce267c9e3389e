#include "images/images_ahead.h"

#include <sys/types.h>
#include <unistd.h>

#include <algorithm>
#include <cstring>
#include <exception>
#include <optional>
#include <string>
#include <type_traits>
#include <utility>

#include "host/child_process.h"
#include "host/message_channel.h"
#include "host/shared_memory.h"

namespace metabuffer {
namespace {

using Images = std::vector<std::shared_ptr<const StoredImage>>;

std::size_t pixels_of(const StoredImage& image) {
    return static_cast<std::size_t>(image.width_pixels()) * static_cast<std::size_t>(image.height_pixels());
}

/// A process with its memory and its channel.
class Worker {
  public:
    Worker(const Images& images, std::size_t most_pixels)
        : memory_(sizeof(ClampedDepths) + most_pixels * sizeof(Pixel)),
          process_([this, &images](const ChildProcess::Sender& /*pipe*/) { serve(images); }) {
        channel_.be_parent();
    }

    /// The image that it reads or has read, by its index.
    std::optional<std::size_t> index() const { return index_; }
    void begin(std::size_t index) {
        index_ = index;
        channel_.send(std::to_string(index));
    }
    /// Waits for the end of its work and says how it ended (MessageChannel).
    std::string finish() {
        index_.reset();
        return channel_.receive();
    }
    /// What it has read last.
    ReadImage image(const StoredImage& stored) const {
        ReadImage image{PixelImage(stored.width_pixels(), stored.height_pixels())};
        std::memcpy(&image.clamped, memory_.begin(), sizeof image.clamped);
        std::memcpy(image.values.data(), pixels(), image.values.size() * sizeof(Pixel));
        return image;
    }

  private:
    static_assert(std::is_trivially_copyable_v<Pixel> && std::is_trivially_copyable_v<ClampedDepths>);

    void* pixels() const { return static_cast<char*>(memory_.begin()) + sizeof(ClampedDepths); }

    /// What the process does until its parent has ended.
    void serve(const Images& images) {
        channel_.be_child();
        // If it fails, its parent tries the same and says why.
        be_silent();
        for (std::string message = channel_.receive(); !message.empty(); message = channel_.receive()) {
            const StoredImage& stored = *images[std::stoul(message)];
            const std::string ending = ending_of([&] {
                const ReadImage image = stored.read();
                std::memcpy(memory_.begin(), &image.clamped, sizeof image.clamped);
                std::memcpy(pixels(), image.values.data(), image.values.size() * sizeof(Pixel));
            });
            if (!channel_.send(ending)) return;
        }
    }

    SharedMemory memory_;
    MessageChannel channel_;
    std::optional<std::size_t> index_;
    ChildProcess process_;
};

/// What the images that are read ahead share.
class Reading {
  public:
    Reading(Images images, std::size_t processes)
        : images_(std::move(images)), is_taken_(images_.size()), left_(images_.size()), owner_(getpid()) {
        std::size_t most_pixels = 0;
        for (const auto& image : images_) most_pixels = std::max(most_pixels, pixels_of(*image));
        try {
            while (workers_.size() < processes && next_ < images_.size()) {
                workers_.push_back(std::make_unique<Worker>(images_, most_pixels));
                begin_next(*workers_.back());
            }
        } catch (const std::exception&) {
            // No memory or no process for one more: the existing processes do the work, or this one does.
        }
    }

    ReadImage take(std::size_t index) {
        const StoredImage& stored = *images_[index];
        if (getpid() != owner_) return stored.read();
        if (!is_taken_[index]) --left_;
        is_taken_[index] = true;
        std::optional<ReadImage> image = taken_from_worker(index);
        return image ? *std::move(image) : stored.read();
    }

  private:
    std::optional<ReadImage> taken_from_worker(std::size_t index) {
        const auto found = std::find_if(workers_.begin(), workers_.end(),
                                        [index](const auto& worker) { return worker->index() == index; });
        std::optional<ReadImage> image;
        if (found != workers_.end()) {
            Worker& worker = **found;
            const std::string ending = worker.finish();
            image = worker.image(*images_[index]);
            if (ending.empty()) {
                workers_.erase(found);
            } else {
                begin_next(worker);
            }
            if (!is_done(ending)) image.reset();
        }
        if (left_ == 0) workers_.clear();
        return image;
    }
    void begin_next(Worker& worker) {
        while (next_ < images_.size() && is_taken_[next_]) ++next_;
        if (next_ < images_.size()) worker.begin(next_++);
    }

    Images images_;
    std::vector<bool> is_taken_;
    std::size_t left_;  ///< that have not been taken
    std::size_t next_ = 0;
    pid_t owner_;
    std::vector<std::unique_ptr<Worker>> workers_;
};

}  // namespace

Images read_ahead(Images images, std::size_t processes) {
    Images ahead;
    ahead.reserve(images.size());
    const auto reading = std::make_shared<Reading>(images, processes);
    for (std::size_t index = 0; index < images.size(); ++index) {
        ahead.push_back(std::make_shared<const StoredImage>(
            ImageSize{images[index]->width_pixels(), images[index]->height_pixels()},
            [reading, index] { return reading->take(index); }));
    }
    return ahead;
}

}  // namespace metabuffer
