// IceT judges level functional: an MPI program with one process for each renderer of a scenario.
//
//   mpiexec -n RANKS icet_judge SCENARIO           every frame of the scenario, at most kMostFrames
//   mpiexec -n RANKS icet_judge --random SEED N    N random walls
//   icet_judge --ranks SCENARIO                    prints how many processes it takes; 0: IceT cannot composite it
//
// Each process gives IceT its renderer's image, placed on the whole wall. The first one compares what IceT makes of them
// with the rasters of level functional: colour, alpha and Z of each pixel. Where two renderers are equally near, IceT may
// show either; such pixels are counted. It then times both on the same images.
//
// Exit status: 0 equal; 1 not; 2 bad arguments.

#include <IceT.h>
#include <IceTMPI.h>
#include <mpi.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <stdexcept>
#include <string>
#include <vector>

#include "icet_scene.h"
#include "scenario/scenario_loader.h"

namespace metabuffer::icet {
namespace {

constexpr int kMostFrames = 3;
constexpr int kTimedTurns = 7;
constexpr int kRoot = 0;

/// Ways in which IceT brings the images of processes together.
struct Way {
    IceTEnum strategy;
    IceTEnum single_image;
    const char* name;
};
constexpr std::array<Way, 5> kWays{{
    {ICET_STRATEGY_SEQUENTIAL, ICET_SINGLE_IMAGE_STRATEGY_AUTOMATIC, "automatic"},
    {ICET_STRATEGY_SEQUENTIAL, ICET_SINGLE_IMAGE_STRATEGY_BSWAP, "binary swap"},
    {ICET_STRATEGY_SEQUENTIAL, ICET_SINGLE_IMAGE_STRATEGY_TREE, "tree"},
    {ICET_STRATEGY_SEQUENTIAL, ICET_SINGLE_IMAGE_STRATEGY_RADIXK, "radix-k"},
    {ICET_STRATEGY_REDUCE, ICET_SINGLE_IMAGE_STRATEGY_AUTOMATIC, "reduce"},
}};

int rank_of_process() {
    int rank = 0;
    MPI_Comm_rank(MPI_COMM_WORLD, &rank);
    return rank;
}

/// IceT with the processes of this program. It has one context at a time.
class Compositor {
  public:
    Compositor() : communicator_(icetCreateMPICommunicator(MPI_COMM_WORLD)) {
        context_ = icetCreateContext(communicator_);
        icetDiagnostics(ICET_DIAG_ERRORS | ICET_DIAG_ALL_NODES);
        icetSetColorFormat(ICET_IMAGE_COLOR_RGBA_UBYTE);
        icetSetDepthFormat(ICET_IMAGE_DEPTH_FLOAT);
        icetCompositeMode(ICET_COMPOSITE_MODE_Z_BUFFER);
        icetDisable(ICET_COMPOSITE_ONE_BUFFER);  // the depths are compared, too
    }
    Compositor(const Compositor&) = delete;
    Compositor& operator=(const Compositor&) = delete;
    ~Compositor() {
        icetDestroyContext(context_);
        icetDestroyMPICommunicator(communicator_);
    }

    void set(const WallSize& wall, const Way& way) {
        icetResetTiles();
        icetAddTile(0, 0, wall.width_pixels, wall.height_pixels, kRoot);
        icetStrategy(way.strategy);
        icetSingleImageStrategy(way.single_image);
    }
    /// All processes call it; the image is whole at the root.
    IceTImage composite(const WallImage& own, const std::array<float, 4>& background) {
        return icetCompositeImage(own.rgba.data(), own.depths.data(), own.viewport, nullptr, nullptr,
                                  background.data());
    }

  private:
    IceTCommunicator communicator_;
    IceTContext context_;
};

/// What comparing two pictures of the wall has found.
struct Outcome {
    std::int64_t pixels = 0;
    std::int64_t won = 0;   ///< by a renderer, alone in front
    std::int64_t tied = 0;  ///< in front with another
    std::int64_t differences = 0;
    std::string first;  ///< "display 1, raster 3,4: ..."
};

std::string text_of(Pixel pixel) {
    std::array<char, 64> text{};
    std::snprintf(text.data(), text.size(), "#%06x A %d Z 0x%06x", pixel.rgb(), pixel.a(), pixel.z());
    return text.data();
}

/// What IceT has at a pixel of the wall. Where nothing is, it has the background.
Pixel pixel_of(IceTImage image, std::size_t n, const Scenario& scenario) {
    const std::uint32_t z = z_of(icetImageGetDepthcf(image)[n], far_z(scenario.depth_format));
    const IceTUByte* const bytes = icetImageGetColorcub(image) + 4 * n;
    return {bytes[0], bytes[1], bytes[2], bytes[3], z};
}

/// The pixels of renderers that are the nearest there; none at the far plane.
std::vector<Pixel> nearest_of(const std::vector<WallImage>& images, std::size_t n, std::uint32_t far) {
    std::vector<Pixel> nearest;
    for (const WallImage& image : images) {
        const std::uint32_t z = z_of(image.depths[n], far);
        if (z == far || (!nearest.empty() && nearest.front().z() < z)) continue;
        if (!nearest.empty() && z < nearest.front().z()) nearest.clear();
        const std::uint8_t* const bytes = &image.rgba[4 * n];
        nearest.emplace_back(bytes[0], bytes[1], bytes[2], bytes[3], z);
    }
    return nearest;
}

void compare(const Scene& scene, const std::vector<WallImage>& images, IceTImage composited,
             Outcome& outcome) {
    const Scenario& scenario = *scene.scenario;
    const DisplayConfig& displays = scenario.displays;
    const WallSize wall = wall_size(displays);
    functional::Compositor compositor(scenario);
    compositor.begin_frame(scene.contributions);
    for (int display = 1; display <= displays.count(); ++display) {
        const PixelImage raster = compositor.raster(display);
        const int left = (display - 1) % displays.columns * displays.raster_width_pixels();
        const int top = (display - 1) / displays.columns * displays.raster_height_pixels();
        for (int y = 0; y < raster.height_pixels; ++y) {
            for (int x = 0; x < raster.width_pixels; ++x) {
                const std::size_t n =
                    static_cast<std::size_t>(top + y) * static_cast<std::size_t>(wall.width_pixels) +
                    static_cast<std::size_t>(left + x);
                const Pixel wanted = pixel_of(composited, n, scenario);
                const Pixel seen = raster.at(x, y);
                const std::vector<Pixel> nearest = nearest_of(images, n, far_z(scenario.depth_format));
                ++outcome.pixels;
                outcome.won += nearest.size() == 1 ? 1 : 0;
                outcome.tied += nearest.size() > 1 ? 1 : 0;
                const bool is_equal =
                    nearest.size() < 2 ? seen == wanted
                                       : seen == nearest.front() && std::find(nearest.begin(), nearest.end(),
                                                                              wanted) != nearest.end();
                if (is_equal) continue;
                if (outcome.differences++ == 0) {
                    outcome.first = "display " + std::to_string(display) + ", raster " + std::to_string(x) +
                                    "," + std::to_string(y) + ": functional " + text_of(seen) + ", IceT " +
                                    text_of(wanted);
                }
            }
        }
    }
}

/// Whether the comparison would find a difference: a bit of IceT's image is changed for that.
bool sees_a_changed_bit(const Scene& scene, const std::vector<WallImage>& images, IceTImage composited) {
    const std::size_t n = wall_size(scene.scenario->displays).pixels() / 2;
    icetImageGetColorub(composited)[4 * n + 1] ^= 1U;
    Outcome outcome;
    compare(scene, images, composited, outcome);
    return outcome.differences == 1;
}

std::array<float, 4> background_of(const Scenario& scenario) {
    constexpr float kWhite = 255.0F;
    const std::uint8_t* const channels = scenario.displays.background;
    return {static_cast<float>(channels[0]) / kWhite, static_cast<float>(channels[1]) / kWhite,
            static_cast<float>(channels[2]) / kWhite, 0.0F};
}

double least(std::vector<double> values) { return *std::min_element(values.begin(), values.end()); }

template <typename Work>
double seconds_of(const Work& work) {
    using Clock = std::chrono::steady_clock;
    const Clock::time_point begun = Clock::now();
    work();
    return std::chrono::duration<double>(Clock::now() - begun).count();
}

/// Keeps the nearer of two images, pixel by pixel: what no compositor can do without.
void keep_nearer(const WallImage& other, WallImage& frame) {
    for (std::size_t n = 0; n < frame.depths.size(); ++n) {
        if (other.depths[n] >= frame.depths[n]) continue;
        frame.depths[n] = other.depths[n];
        std::copy_n(&other.rgba[4 * n], 4, &frame.rgba[4 * n]);
    }
}

/// Seconds of a frame on the same images, the least of several turns.
struct Times {
    double icet = 0.0;
    double functional = 0.0;
    double bare_loop = 0.0;
};

Times timed(Compositor& icet, const Scene& scene, const std::vector<WallImage>& images,
            const WallImage& own) {
    const Scenario& scenario = *scene.scenario;
    icet.set(wall_size(scenario.displays), kWays.front());
    std::vector<double> of_icet;
    for (int turn = 0; turn < kTimedTurns; ++turn) {
        MPI_Barrier(MPI_COMM_WORLD);
        of_icet.push_back(seconds_of([&] {
            icet.composite(own, background_of(scenario));
            MPI_Barrier(MPI_COMM_WORLD);
        }));
    }
    if (rank_of_process() != kRoot) return {};
    const Scenario same = scenario_of(images, scenario);
    const auto contributions = functional::contributions_of(same, std::vector<int>(same.renderers.size(), 0));
    std::vector<double> of_functional;
    std::vector<double> of_loop;
    for (int turn = 0; turn < kTimedTurns; ++turn) {
        // With all that a frame of new images takes. Pictures include averaging and correction, which IceT has not.
        of_functional.push_back(seconds_of([&] {
            functional::Compositor compositor(same);
            compositor.begin_frame(contributions);
            for (int display = 1; display <= same.displays.count(); ++display) compositor.picture(display);
        }));
        WallImage frame = images.front();
        of_loop.push_back(seconds_of([&] {
            for (std::size_t r = 1; r < images.size(); ++r) keep_nearer(images[r], frame);
        }));
    }
    return {least(of_icet), least(of_functional), least(of_loop)};
}

/// Whether IceT's part of the frame and level functional's are equal, however IceT goes about it. Prints a line.
bool judge(Compositor& icet, const Scene& scene, bool with_times) {
    const int rank = rank_of_process();
    const WallImage own = placed(scene, static_cast<std::size_t>(rank));
    std::vector<WallImage> images;
    if (rank == kRoot) {
        for (std::size_t r = 0; r < scene.contributions.size(); ++r) images.push_back(placed(scene, r));
    }
    int is_equal = 1;
    Outcome outcome;
    IceTImage composited = icetImageNull();
    for (const Way& way : kWays) {
        icet.set(wall_size(scene.scenario->displays), way);
        composited = icet.composite(own, background_of(*scene.scenario));
        if (rank != kRoot || is_equal == 0) continue;
        outcome = {};
        compare(scene, images, composited, outcome);
        if (outcome.differences == 0) continue;
        is_equal = 0;
        std::printf("%s, %s: %lld of %lld pixels differ; %s\n", scene.name.c_str(), way.name,
                    static_cast<long long>(outcome.differences), static_cast<long long>(outcome.pixels),
                    outcome.first.c_str());
    }
    if (rank == kRoot && is_equal != 0 && !with_times && !sees_a_changed_bit(scene, images, composited)) {
        std::printf("%s: a changed bit is not found\n", scene.name.c_str());
        is_equal = 0;
    }
    MPI_Bcast(&is_equal, 1, MPI_INT, kRoot, MPI_COMM_WORLD);
    if (is_equal == 0 || !with_times) return is_equal != 0;
    const Times times = timed(icet, scene, images, own);
    if (rank == kRoot) {
        const WallSize wall = wall_size(scene.scenario->displays);
        std::printf("%-28s %6d x %-5d %2zu %9lld %6lld %9.3f %11.3f %10.3f\n", scene.name.c_str(),
                    wall.width_pixels, wall.height_pixels, images.size(), static_cast<long long>(outcome.won),
                    static_cast<long long>(outcome.tied), 1e3 * times.icet, 1e3 * times.functional,
                    1e3 * times.bare_loop);
    }
    return true;
}

bool judge_scenario(Compositor& icet, const std::string& file) {
    const Scenario scenario = load_scenario(file);
    const std::vector<std::vector<int>> pairs = functional::pairs_without_time(scenario);
    const int frames = std::min(scenario.frames, kMostFrames);
    bool is_equal = true;
    for (int frame = 0; frame < frames; ++frame) {
        const std::string number = scenario.frames == 1 ? "" : ", frame " + std::to_string(frame);
        const Scene scene{scenario.name + number, &scenario,
                          functional::contributions_of(scenario, pairs[static_cast<std::size_t>(frame)])};
        is_equal = judge(icet, scene, true) && is_equal;
    }
    return is_equal;
}

bool judge_random(Compositor& icet, std::uint64_t seed, int count, std::size_t renderers) {
    bool is_equal = true;
    for (int n = 0; n < count; ++n) {
        const Scenario scenario = random_wall(seed + static_cast<std::uint64_t>(n), renderers);
        const Scene scene{scenario.name, &scenario,
                          functional::contributions_of(scenario, std::vector<int>(renderers, 0))};
        is_equal = judge(icet, scene, false) && is_equal;
    }
    if (is_equal && rank_of_process() == kRoot) {
        std::printf("%d random walls of %zu renderers, from seed %llu on: equal\n", count, renderers,
                    static_cast<unsigned long long>(seed));
    }
    return is_equal;
}

/// 0 if IceT cannot composite it: another composition than z, or too many renderers.
std::size_t ranks_of(const std::string& file) {
    const Scenario scenario = load_scenario(file);
    const std::size_t renderers = scenario.renderers.size();
    return scenario.composition == Composition::kZ && renderers <= kMostRanks ? renderers : 0;
}

int judged(const std::vector<std::string>& words) {
    int size = 0;
    MPI_Comm_size(MPI_COMM_WORLD, &size);
    const auto ranks = static_cast<std::size_t>(size);
    Compositor icet;
    const bool is_random = words.size() == 3 && words[0] == "--random";
    if (!is_random && (words.size() != 1 || ranks_of(words[0]) != ranks)) {
        throw std::runtime_error("use SCENARIO with a process for each renderer, or --random SEED N");
    }
    const bool is_equal = is_random ? judge_random(icet, std::stoull(words[1]), std::stoi(words[2]), ranks)
                                    : judge_scenario(icet, words[0]);
    return is_equal ? 0 : 1;
}

int main_program(int argc, char** argv) {
    const std::vector<std::string> words(argv + 1, argv + argc);
    if (words.size() == 2 && words[0] == "--ranks") {
        std::printf("%zu\n", ranks_of(words[1]));
        return 0;
    }
    MPI_Init(&argc, &argv);
    int status = 2;
    try {
        status = judged(words);
    } catch (const std::exception& error) {
        std::fprintf(stderr, "icet_judge: %s\n", error.what());
        MPI_Abort(MPI_COMM_WORLD, status);
    }
    MPI_Finalize();
    return status;
}

}  // namespace
}  // namespace metabuffer::icet

int main(int argc, char** argv) {
    try {
        return metabuffer::icet::main_program(argc, argv);
    } catch (const std::exception& error) {
        std::fprintf(stderr, "icet_judge: %s\n", error.what());
        return 2;
    }
}
