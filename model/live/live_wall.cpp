#include "live/live_wall.h"

#include <poll.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <iterator>
#include <utility>

#include "datapath/arbitration/arbitration_table.h"
#include "formats/control_scanline.h"
#include "host/errors.h"
#include "host/text.h"
#include "scenario/derived_timing.h"
#include "scenario/link_program.h"
#include "scenario/names.h"

namespace metabuffer::live {
namespace {

/// Applications that have connected and have not said who they are.
constexpr std::size_t kMostNewcomers = 16;
constexpr std::chrono::milliseconds kLongestPoll{50};
/// More than the frames that may have begun in the machine and not been shown: two in the displays' buffers, one on its
/// way through the pipeline, one that is asked for; and level tlm works up to a raster ahead of what it shows.
constexpr int kFramesUnderWay = 8;

[[noreturn]] void fail_to_listen(const std::filesystem::path& path, const std::string& why) {
    throw InputError(
        text::located(path.string(), "cannot be listened at: " + why + "; use another --socket"));
}

/// The path must be short enough.
sockaddr_un address_of(const std::string& path) {
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    std::copy(path.begin(), path.end(), static_cast<char*>(address.sun_path));
    return address;
}

/// Whether a wall listens there.
bool is_alive(const std::string& path) {
    const sockaddr_un address = address_of(path);
    const int descriptor = socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
    const bool connected =
        connect(descriptor, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0;
    ::close(descriptor);
    return connected;
}

int listen_at(const std::filesystem::path& path) {
    const std::string name = path.string();
    // Made under another name: once it has its own, it is this user's alone, and applications can connect.
    const std::string aside = name + "~";
    if (aside.size() >= sizeof(sockaddr_un::sun_path)) {
        fail_to_listen(
            path, "its path is longer than " + std::to_string(sizeof(sockaddr_un::sun_path) - 2) + " bytes");
    }
    struct stat file {};
    if (lstat(name.c_str(), &file) == 0) {
        if (!S_ISSOCK(file.st_mode)) fail_to_listen(path, "a file of that name is there");
        if (is_alive(name)) fail_to_listen(path, "another wall listens there");
    }
    unlink(aside.c_str());  // of a wall that was killed
    const sockaddr_un address = address_of(aside);
    const int listener = socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
    const bool listens =
        listener >= 0 && bind(listener, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0 &&
        chmod(aside.c_str(), S_IRUSR | S_IWUSR) == 0 &&
        listen(listener, static_cast<int>(kMostNewcomers)) == 0 && rename(aside.c_str(), name.c_str()) == 0;
    if (!listens) {
        const std::string why = std::strerror(errno);
        if (listener >= 0) ::close(listener);
        unlink(aside.c_str());
        fail_to_listen(path, why);
    }
    return listener;
}

std::int32_t slots_wanted(const BusConfig& bus) {
    if (bus.slot_table != SlotTableMaker::kHost) return METABUFFER_NO_SLOTS;
    const auto table = arbitration_row(bus.arbitration).slot_table;
    if (table == nullptr) return METABUFFER_NO_SLOTS;
    return table == slot_table ? METABUFFER_PROPORTIONAL_SLOTS : METABUFFER_EQUAL_SLOTS;
}

metabuffer_link_info info_of(const Scenario& scenario, const Renderer& renderer) {
    const DisplayWall wall = scenario.displays.wall();
    metabuffer_link_info info{};
    info.wall = {wall.columns,
                 wall.rows,
                 wall.raster_width_pixels,
                 wall.raster_height_pixels,
                 wall.gap_x_pixels,
                 wall.gap_y_pixels,
                 scenario.composer.smoothing == Smoothing::kReplicate ? 0 : 1};
    info.depth_format = scenario.depth_format == DepthFormat::kZ24 ? METABUFFER_Z24 : METABUFFER_A8Z16;
    info.image_width_pixels = renderer.image_width_pixels;
    info.image_height_pixels = renderer.image_height_pixels;
    info.lockstep = scenario.pacing == Pacing::kLockstep ? 1 : 0;
    info.slots_wanted = slots_wanted(scenario.bus);
    info.buffer_pixels = scenario.composer.buffer_pixels;
    info.ready_space_pixels = scenario.composer.ready_space_pixels;
    return info;
}

}  // namespace

LiveWall::LiveWall(Scenario& scenario, LiveOptions options)
    : scenario_(scenario), options_(std::move(options)), listener_(listen_at(options_.socket)) {
    for (std::size_t r = 0; r < scenario.renderers.size(); ++r) {
        if (!scenario.renderers[r].is_live) continue;
        links_.emplace_back();
        links_.back().renderer = static_cast<int>(r);
    }
}

LiveWall::~LiveWall() {
    ::close(listener_);
    unlink(options_.socket.c_str());
}

bool LiveWall::has_pairs() const {
    return std::any_of(links_.begin(), links_.end(), [](const Link& link) { return link.taken > 0; });
}

void LiveWall::frame_shown(int frame, const std::vector<int>& pairs) {
    shown_ = std::max(shown_, frame);
    if (options_.keeps_pairs) return;
    for (Link& link : links_) {
        const Renderer& renderer = renderer_of(link);
        const int number = pairs[static_cast<std::size_t>(link.renderer)];
        if (number < 0) continue;
        const std::uint32_t pair = renderer.pair_of_number(static_cast<std::uint32_t>(number));
        for (; link.forgotten < renderer.frame_of_pair(pair).image; ++link.forgotten) {
            renderer.images[link.forgotten]->forget();
        }
    }
}

void LiveWall::report(const std::string& line) const {
    if (options_.on_event) options_.on_event(text::one_line(line));
}

// ---- applications ----

bool LiveWall::all_gone() const {
    return std::all_of(links_.begin(), links_.end(), [this](const Link& link) {
        return is_gone(link) || (link.application && link.application->descriptor() < 0);
    });
}

bool LiveWall::anybody_came() const {
    return std::any_of(links_.begin(), links_.end(), [](const Link& link) { return link.had_application; });
}

/// Handles what has come from applications. Waits for something to come if nothing has, but not long.
void LiveWall::serve(std::chrono::duration<double> longest) {
    std::vector<pollfd> wanted{{options_.stop_descriptor, POLLIN, 0}, {listener_, POLLIN, 0}};
    for (const auto& newcomer : newcomers_) wanted.push_back({newcomer->descriptor(), POLLIN, 0});
    for (const Link& link : links_) {
        wanted.push_back({link.application ? link.application->descriptor() : -1, POLLIN, 0});
    }
    const auto time = std::chrono::duration_cast<std::chrono::milliseconds>(
        std::clamp<std::chrono::duration<double>>(longest, std::chrono::milliseconds(0), kLongestPoll));
    if (poll(wanted.data(), wanted.size(), static_cast<int>(time.count())) < 0) return;
    if ((wanted[0].revents & POLLIN) != 0) end();

    for (Link& link : links_) receive(link);
    for (std::size_t n = newcomers_.size(); n-- > 0;) {
        const bool lives = newcomers_[n]->receive();
        const bool speaks = newcomers_[n]->hello().has_value();
        if (lives && !speaks) continue;
        std::unique_ptr<ApplicationLink> newcomer = std::move(newcomers_[n]);
        newcomers_.erase(newcomers_.begin() + static_cast<std::ptrdiff_t>(n));
        if (speaks) welcome(std::move(newcomer));
    }
    if ((wanted[1].revents & POLLIN) != 0) accept_application();
}

void LiveWall::accept_application() {
    const int descriptor = accept4(listener_, nullptr, nullptr, SOCK_CLOEXEC);
    if (descriptor < 0) return;
    auto application = std::make_unique<ApplicationLink>(descriptor);
    if (!application->is_of_this_user()) {
        application->refuse("the wall is another user's");
        report("refused an application of another user");
        return;
    }
    if (newcomers_.size() == kMostNewcomers) newcomers_.erase(newcomers_.begin());
    newcomers_.push_back(std::move(application));
}

LiveWall::Link* LiveWall::link_of(const std::string& name) {
    const auto link = std::find_if(links_.begin(), links_.end(),
                                   [&](const Link& one) { return renderer_of(one).name == name; });
    return link == links_.end() ? nullptr : &*link;
}

/// Why that application cannot have the link; empty if it can. link: null if no live renderer has the name.
std::string LiveWall::refusal(const live_hello& hello, const Link* link) const {
    if (hello.magic != LIVE_MAGIC) return "does not speak the protocol of metabuffer_host.h";
    if (hello.version != LIVE_VERSION) {
        return "speaks version " + std::to_string(hello.version) + " of the protocol; use version " +
               std::to_string(LIVE_VERSION);
    }
    const std::string name = text::quoted(static_cast<const char*>(hello.link_name));
    if (link == nullptr) {
        std::vector<std::string> names;
        for (const Link& one : links_) names.push_back(text::quoted(renderer_of(one).name));
        return name + " is not a live renderer; use " + text::joined(names, "or");
    }
    if (link->application) return name + " has an application already; use another renderer";
    const metabuffer_link_info info = info_of(scenario_, renderer_of(*link));
    const auto size = [](std::int32_t width, std::int32_t height) {
        return std::to_string(width) + "x" + std::to_string(height);
    };
    const std::string asked = size(hello.image_width_pixels, hello.image_height_pixels);
    const std::string needed = size(info.image_width_pixels, info.image_height_pixels);
    if (asked != needed && asked != size(0, 0)) {
        return name + " has images of " + needed + " pixels, not " + asked + "; use the size of its key live";
    }
    if (hello.depth_format != METABUFFER_ANY_DEPTH && hello.depth_format != info.depth_format) {
        return name + " has depths of format " + to_string(scenario_.depth_format) + "; use that one";
    }
    return {};
}

void LiveWall::welcome(std::unique_ptr<ApplicationLink> application) {
    const live_hello& hello = *application->hello();
    Link* const link = link_of(static_cast<const char*>(hello.link_name));
    std::string why = refusal(hello, link);
    if (why.empty() && !application->accept(info_of(scenario_, renderer_of(*link)), link->begun)) {
        why = "the system has no memory for it";
    }
    if (!why.empty()) {
        application->refuse(why);
        report("refused an application: " + why);
        return;
    }
    report(text::quoted(renderer_of(*link).name) + ": an application has come");
    link->application = std::move(application);
    link->had_application = true;
}

void LiveWall::receive(Link& link) {
    if (!link.application) return;
    if (link.application->receive()) return;
    if (!link.application->fault().empty()) {
        close(link, link.application->fault());
    } else if (link.application->waiting() == 0) {
        close(link, "");
    }
}

/// why: what the application has done wrong; empty if it has ended by itself.
void LiveWall::close(Link& link, const std::string& why) {
    const std::string name = text::quoted(renderer_of(link).name);
    report(name +
           (why.empty() ? ": its application has gone" : ": its application " + why + ", and is cut off") +
           ", after " + text::counted(link.taken, "pair"));
    link.application.reset();
}

// ---- pairs ----

/// How many pairs the link has begun, or is sure to.
std::uint32_t LiveWall::pairs_to_come(const Link& link) const {
    return link.begun + (link.application ? static_cast<std::uint32_t>(link.application->waiting()) : 0U);
}

/// No frame begins any more that no link has begun a pair for.
void LiveWall::end() {
    if (ended_) return;
    ended_ = true;
    std::uint32_t pairs = 1;
    for (const Link& link : links_) pairs = std::max(pairs, link.begun);
    if (all_gone()) {
        for (const Link& link : links_) pairs = std::max(pairs, pairs_to_come(link));
    }
    int frames = static_cast<int>(pairs);
    if (scenario_.pacing == Pacing::kFreeRunning) frames = 1;
    if (scenario_.pacing == Pacing::kFreeRunning || !all_gone()) {
        frames = std::max(frames, shown_ + kFramesUnderWay);
    }
    scenario_.frames = std::min(scenario_.frames, frames);
}

LivePairs::Next LiveWall::next(int renderer, std::uint32_t pair) {
    Link& link = *std::find_if(links_.begin(), links_.end(),
                               [renderer](const Link& one) { return one.renderer == renderer; });
    serve(std::chrono::seconds(0));
    // After a reset a link begins with its first pair again.
    if (pair + (link.silent ? 1 : 0) < link.begun) return Next::kPair;
    return scenario_.pacing == Pacing::kLockstep ? next_in_lockstep(link, pair)
                                                 : next_free_running(link, pair);
}

LivePairs::Next LiveWall::next_in_lockstep(Link& link, std::uint32_t pair) {
    const Clock::time_point asked = Clock::now();
    while (true) {
        if (take(link, pair)) return Next::kPair;
        if (all_gone()) end();
        if (ended_ && pair >= static_cast<std::uint32_t>(scenario_.frames)) return Next::kEnd;
        if (ended_) return silence(link, pair);
        // Where an application has gone, the others say whether there is another frame.
        const bool others_go_on = std::any_of(links_.begin(), links_.end(), [&](const Link& other) {
            return &other != &link && pairs_to_come(other) > pair;
        });
        const bool is_late = anybody_came() && Clock::now() - asked >= options_.wait;
        if (is_gone(link) && (others_go_on || is_late)) return silence(link, pair);
        if (is_late) return missing(link, pair);
        if (options_.on_wait) options_.on_wait();
        serve(kLongestPoll);
    }
}

LivePairs::Next LiveWall::next_free_running(Link& link, std::uint32_t pair) {
    if (options_.real_time) {
        const Renderer& renderer = renderer_of(link);
        const std::chrono::duration<double> begins(static_cast<double>(pair) *
                                                   static_cast<double>(pair_clocks(renderer)) /
                                                   (scenario_.clocks.dvi_in_mhz * 1e6));
        while (!ended_ && Clock::now() - started_ < begins) {
            if (options_.on_wait) options_.on_wait();
            serve(begins - (Clock::now() - started_));
        }
    }
    while (link.application && link.application->waiting() > 1) link.application->drop(0);
    for (bool waits = !anybody_came(); waits && !ended_;) {
        if (options_.on_wait) options_.on_wait();
        serve(kLongestPoll);
        waits = std::none_of(links_.begin(), links_.end(), [](const Link& one) {
            return one.application && one.application->waiting() > 0;
        });
    }
    if (take(link, pair)) return Next::kPair;
    if (all_gone()) end();
    if (!link.application || link.taken == 0) return silence(link, pair);
    begin(link, pair);  // with the one before it, again
    return Next::kPair;
}

/// The link begins the pair, or is silent before it. Returns the renderer's frame of it, at first that of the one before.
RendererFrame& LiveWall::begin(Link& link, std::uint32_t pair, bool silent) {
    link.begun = pair + 1;
    link.silent = silent;
    std::vector<RendererFrame>& frames = renderer_of(link).frames;
    while (frames.size() <= pair) frames.push_back(RendererFrame(frames.back()));
    return frames[pair];
}

/// Takes the link's oldest pair, if that is the one asked for. Earlier ones were missing and come too late.
bool LiveWall::take(Link& link, std::uint32_t pair) {
    const bool in_order = scenario_.pacing == Pacing::kLockstep;
    while (link.application && link.application->waiting() > 0) {
        if (in_order && link.application->oldest_number() < pair) {
            link.application->drop(pair);
            continue;
        }
        if (add_pair(link, pair, link.application->take(in_order ? pair : 0, options_.needs_pixels))) {
            return true;
        }
    }
    receive(link);
    return false;
}

/// False, and the link is cut off, if the pair has a number that would make it another one.
bool LiveWall::add_pair(Link& link, std::uint32_t pair, ApplicationPair sent) {
    Renderer& renderer = renderer_of(link);
    const DecodedScanline colour = decode_control_scanline(sent.colour_control);
    if (colour.defect == ScanlineDefect::kNone && colour.content.frame_number != sent.number) {
        close(link, "numbers a pair " + std::to_string(colour.content.frame_number) + " instead of " +
                        std::to_string(sent.number));
        return false;
    }
    RendererFrame& frame = begin(link, pair);
    frame = RendererFrame{};
    frame.image = renderer.images.size();
    const ImageSize size{renderer.image_width_pixels, renderer.image_height_pixels};
    renderer.images.push_back(options_.needs_pixels
                                  ? std::make_shared<const StoredImage>(std::move(sent.pixels))
                                  : std::make_shared<const StoredImage>(size, StoredImage::Read()));
    SentControls controls = sent_controls(sent.colour_control, sent.depth_control);
    frame.table = controls.table;
    const auto of_host = [&](FrameKind kind) {
        return encode_control_scanline(control_content(scenario_, renderer, pair, kind),
                                       renderer.image_width_pixels);
    };
    // A pair that is sent again later has the same number then.
    if (scenario_.pacing == Pacing::kFreeRunning || of_host(FrameKind::kColour) != controls.colour ||
        of_host(FrameKind::kDepth) != controls.depth) {
        frame.controls = std::move(controls);
    }
    ++link.taken;
    return true;
}

LivePairs::Next LiveWall::missing(Link& link, std::uint32_t pair) {
    begin(link, pair);
    for (const FrameKind frame : {FrameKind::kColour, FrameKind::kDepth}) {
        scenario_.faults.push_back({link.renderer, pair, FaultKind::kMissing, frame});
    }
    return Next::kMissing;
}

LivePairs::Next LiveWall::silence(Link& link, std::uint32_t pair) {
    if (link.silent && link.begun == pair + 1) {
        ++scenario_.faults[link.silence].delay_pairs;
        return Next::kSilence;
    }
    begin(link, pair, true);
    link.silence = scenario_.faults.size();
    scenario_.faults.push_back({link.renderer, pair, FaultKind::kDelay, FrameKind::kColour, 1});
    return Next::kSilence;
}

}  // namespace metabuffer::live
