// A simulator in the style of the paper's (section 7): one POSIX thread for each composer and each framebuffer, which
// all meet at a barrier every clock. It does no more per clock than the pipelines' Z compare, so it flatters that
// style: no bus, no arbiter, no buffers, no links. scripts/benchmark compares the clocked model with it.
//
// usage: thread_per_composer [RENDERERS [DISPLAYS [CLOCKS]]]; prints one JSON object.

#include <pthread.h>

#include <chrono>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include "datapath/composition.h"
#include "formats/pixel.h"

namespace metabuffer {
namespace {

constexpr int kRasterWidth = 320;
constexpr int kRasterHeight = 240;
constexpr int kRasterPixels = kRasterWidth * kRasterHeight;
constexpr int kCacheLineBytes = 64;

/// A register between two clocks: what is written in clock t is read in clock t + 1. It has two halves, used in turn,
/// so that one barrier a clock is enough. It has its own cache line, or neighbours would slow each other down.
class alignas(kCacheLineBytes) PipelineRegister {
  public:
    Pixel read(std::int64_t clock) const { return halves_[static_cast<std::size_t>(clock & 1)]; }
    void write(std::int64_t clock, Pixel pixel) {
        halves_[static_cast<std::size_t>((clock + 1) & 1)] = pixel;
    }

  private:
    Pixel halves_[2];
};

class Barrier {
  public:
    explicit Barrier(int threads) {
        if (pthread_barrier_init(&barrier_, nullptr, static_cast<unsigned>(threads)) != 0) {
            throw std::runtime_error("no barrier for " + std::to_string(threads) + " threads");
        }
    }
    Barrier(const Barrier&) = delete;
    Barrier& operator=(const Barrier&) = delete;
    ~Barrier() { pthread_barrier_destroy(&barrier_); }
    void wait() { pthread_barrier_wait(&barrier_); }

  private:
    pthread_barrier_t barrier_{};
};

/// A renderer's picture as a composer receives it: a disc in front of nothing, with its own position and depth, nearest
/// in the middle as a ball is. About a third of the pixels wins somewhere, in runs as in real pictures.
std::vector<Pixel> ball(int renderer, int display) {
    constexpr int kRadius = 100;
    const int centre_x = (renderer * 97 + display * 31) % kRasterWidth;
    const int centre_y = (renderer * 61 + display * 17) % kRasterHeight;
    std::vector<Pixel> pixels;
    pixels.reserve(kRasterPixels);
    for (int y = 0; y < kRasterHeight; ++y) {
        for (int x = 0; x < kRasterWidth; ++x) {
            const int square = (x - centre_x) * (x - centre_x) + (y - centre_y) * (y - centre_y);
            const int depth = 1000 * (renderer + 1) + square;
            const bool hit = square < kRadius * kRadius;
            pixels.emplace_back(static_cast<std::uint8_t>(40 * renderer), static_cast<std::uint8_t>(x),
                                static_cast<std::uint8_t>(y), hit ? std::uint8_t{255} : std::uint8_t{0},
                                hit ? static_cast<std::uint32_t>(depth) : far_z(DepthFormat::kA8Z16));
        }
    }
    return pixels;
}

/// What one pixel adds to a display's checksum. The order of the pixels counts.
std::uint64_t mixed(std::uint64_t sum, Pixel pixel) { return (sum ^ pixel.word()) * 0x9E37'79B9'7F4A'7C15U; }

class Machine {
  public:
    Machine(int renderers, int displays, std::int64_t clocks)
        : renderers_(renderers),
          displays_(displays),
          clocks_(clocks),
          locals_(composers()),
          pipes_(composers()),
          pictures_(composers()),
          checksums_(static_cast<std::size_t>(displays)),
          barrier_(threads()) {
        for (int r = 0; r < renderers; ++r) {
            for (int d = 0; d < displays; ++d) pictures_[at(r, d)] = ball(r, d);
        }
    }

    /// Runs all clocks; returns the seconds they took, without the creation of the threads.
    double run() {
        std::vector<std::thread> threads;
        for (int r = 0; r < renderers_; ++r) {
            threads.emplace_back([this, r] { clocked([this, r](std::int64_t t) { clock_input(r, t); }); });
            for (int d = 0; d < displays_; ++d) {
                threads.emplace_back(
                    [this, r, d] { clocked([this, r, d](std::int64_t t) { clock_composer(r, d, t); }); });
            }
        }
        for (int d = 0; d < displays_; ++d) {
            threads.emplace_back([this, d] { clocked([this, d](std::int64_t t) { clock_output(d, t); }); });
        }
        barrier_.wait();  // all are there
        const auto started = std::chrono::steady_clock::now();
        for (std::int64_t t = 0; t < clocks_; ++t) barrier_.wait();
        const std::chrono::duration<double> taken = std::chrono::steady_clock::now() - started;
        for (std::thread& thread : threads) thread.join();
        return taken.count();
    }

    /// Whether every display got the pixels that a plain loop over the pictures gives.
    bool right() const {
        for (int d = 0; d < displays_; ++d) {
            std::uint64_t sum = 0;
            // A pixel that the input framebuffers put out in clock t leaves the last composer `renderers`
            // clocks later.
            for (std::int64_t t = renderers_ + 1; t < clocks_; ++t) {
                Pixel pixel = background();
                for (int r = 0; r < renderers_; ++r) {
                    pixel = compose(Composition::kZ, picture_pixel(r, d, t - renderers_ - 1), pixel);
                }
                sum = mixed(sum, pixel);
            }
            if (sum != checksums_[static_cast<std::size_t>(d)]) return false;
        }
        return true;
    }

    std::size_t composers() const {
        return static_cast<std::size_t>(renderers_) * static_cast<std::size_t>(displays_);
    }
    /// The composers, a framebuffer at the start of each bus and at the end of each pipeline, and the thread that gives
    /// the clock.
    int threads() const { return renderers_ * displays_ + renderers_ + displays_ + 1; }

  private:
    static Pixel background() { return {0, 0, 0, 0, far_z(DepthFormat::kA8Z16)}; }
    std::size_t at(int r, int d) const {
        return static_cast<std::size_t>(r) * static_cast<std::size_t>(displays_) +
               static_cast<std::size_t>(d);
    }
    Pixel picture_pixel(int r, int d, std::int64_t index) const {
        return pictures_[at(r, d)][static_cast<std::size_t>(index % kRasterPixels)];
    }

    void clocked(const std::function<void(std::int64_t)>& clock) {
        barrier_.wait();
        for (std::int64_t t = 0; t < clocks_; ++t) {
            clock(t);
            barrier_.wait();
        }
    }
    /// Composer row r works r clocks after the first, so its input comes r clocks later.
    void clock_input(int r, std::int64_t t) {
        for (int d = 0; d < displays_; ++d) {
            locals_[at(r, d)].write(t, t >= r ? picture_pixel(r, d, t - r) : background());
        }
    }
    void clock_composer(int r, int d, std::int64_t t) {
        const Pixel upstream = r == 0 ? background() : pipes_[at(r - 1, d)].read(t);
        pipes_[at(r, d)].write(t, compose(Composition::kZ, locals_[at(r, d)].read(t), upstream));
    }
    void clock_output(int d, std::int64_t t) {
        if (t <= renderers_) return;
        std::uint64_t& sum = checksums_[static_cast<std::size_t>(d)];
        sum = mixed(sum, pipes_[at(renderers_ - 1, d)].read(t));
    }

    int renderers_;
    int displays_;
    std::int64_t clocks_;
    std::vector<PipelineRegister> locals_;
    std::vector<PipelineRegister> pipes_;
    std::vector<std::vector<Pixel>> pictures_;
    std::vector<std::uint64_t> checksums_;
    Barrier barrier_;
};

/// The argument at `index` as a whole number from 1 to `high`, or the default if there is none.
int argument(int argc, char** argv, int index, int default_value, int high) {
    if (index >= argc) return default_value;
    char* end = nullptr;
    const long value = std::strtol(argv[index], &end, 10);
    if (*end != '\0' || value < 1 || value > high) {
        throw std::runtime_error(std::string(argv[index]) + ": use a whole number from 1 to " +
                                 std::to_string(high));
    }
    return static_cast<int>(value);
}

int main_program(int argc, char** argv) {
    const int renderers = argument(argc, argv, 1, 3, 100);
    const int displays = argument(argc, argv, 2, 4, 100);
    const int clocks = argument(argc, argv, 3, 20000, 1'000'000'000);
    Machine machine(renderers, displays, clocks);
    const double seconds = machine.run();
    if (!machine.right()) {
        std::fputs("thread_per_composer: wrong pixels\n", stderr);
        return 1;
    }
    std::printf(
        "{\"composers\": %zu, \"threads\": %d, \"clocks\": %d, \"composer_clocks\": %.0f, \"seconds\": "
        "%.6f}\n",
        machine.composers(), machine.threads(), clocks, static_cast<double>(machine.composers()) * clocks,
        seconds);
    return 0;
}

}  // namespace
}  // namespace metabuffer

int main(int argc, char** argv) {
    try {
        return metabuffer::main_program(argc, argv);
    } catch (const std::exception& error) {
        std::fprintf(stderr, "thread_per_composer: %s\n", error.what());
        return 2;
    }
}
