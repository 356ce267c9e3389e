#include "monitors/scoreboard.h"

#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <unordered_map>
#include <utility>

#include "rtl/block.h"
#include "rtl/wires.h"
#include "scenario/fault_keys.h"

namespace metabuffer::monitors {
namespace {

/// Clocks of a waveform around a wrong value.
constexpr std::int64_t kClocksAround = 20;

}  // namespace

/// What is known of a renderer's bus.
struct Scoreboard::Bus {
    std::set<std::int64_t> whole_pairs;  ///< that EVENT has reported; older ones are removed
    int frame = -1;                      ///< under way, from 0
    int pair = -1;
    bool known = false;  ///< it is known what the frame is made of
    functional::Contribution contribution;
    std::vector<const ViewportRow*> row_of_display;
    std::size_t rows = 0;   ///< broadcast so far
    bool reported = false;  ///< a wrong pixel in this frame has been reported
    // Of a link that errs.
    std::shared_ptr<PixelImage> coming;  ///< what has been received of the pair under way
    std::map<std::int64_t, std::shared_ptr<const PixelImage>> received;  ///< by whole pair
};

/// What is known of a display's pipeline.
struct Scoreboard::Column {
    bool stood_still = false;  ///< COLUMNSTALL was high at the edge before
    // What the composers have put out at the last edges without a stall, by edge modulo the number of composers.
    std::vector<std::vector<std::uint64_t>> words;
    std::vector<std::int64_t> cycles;
    std::size_t now = 0;

    int frame = -1;
    int position = 0;  ///< of the next raster pixel at the bottom, 0: between frames
    bool known = false;
    bool reported = false;  ///< a wrong pixel in this frame has been reported
    PixelImage raster;      ///< the functional level's, less what starved
    std::unordered_map<std::int64_t, std::vector<int>> starved;  ///< renderers by frame and position

    std::map<std::int64_t, ColourImage> pictures;  ///< composited and not yet shown, by frame
    std::map<std::int64_t, std::string> wrong;     ///< what was reported of their pixels
    ColourImage shown;
};

Scoreboard::Scoreboard(const sc_core::sc_module_name& name, const Scenario& scenario, rtl::Wires& wires,
                       sc_core::sc_signal_in_if<bool>& core_clk, sc_core::sc_signal_in_if<bool>& reset,
                       PairOfFrame pair_of_frame, ViolationLog& log)
    : sc_core::sc_module(name),
      scenario_(scenario),
      wires_(wires),
      pair_of_frame_(std::move(pair_of_frame)),
      log_(log),
      renderers_(scenario.renderers.size()),
      displays_(static_cast<std::size_t>(scenario.displays.count())),
      raster_width_(scenario.displays.raster_width_pixels()),
      raster_pixels_of_frame_(raster_width_ * scenario.displays.raster_height_pixels()),
      may_stall_(scenario.composer.may_stall()),
      core_period_picoseconds_(clock_period_picoseconds(scenario.clocks.core_mhz)),
      reference_(scenario),
      compositor_(scenario),
      link_errs_(renderers_),
      buses_(renderers_),
      columns_(displays_) {
    restart();
    clk_i_(core_clk);
    reset_i_(reset);
    SC_METHOD(core_edge);
    sensitive << clk_i_.pos();
    dont_initialize();
    for (std::size_t r = 0; r < renderers_; ++r) link_errs_[r] = disturbs_characters(scenario, r);
    if (disturbs_characters(scenario)) {
        SC_METHOD(take_pixels);
        for (std::size_t r = 0; r < renderers_; ++r) {
            if (link_errs_[r]) sensitive << wires_.pixel[r].value_changed_event();
        }
        dont_initialize();
    }
    SC_METHOD(take_events);
    for (std::size_t r = 0; r < renderers_; ++r) sensitive << wires_.event[r].value_changed_event();
    dont_initialize();
}

Scoreboard::~Scoreboard() = default;

/// After a reset frames are numbered from 0 again.
void Scoreboard::restart() {
    for (Bus& bus : buses_) bus = Bus();
    for (Column& column : columns_) {
        column = Column();
        column.words.assign(renderers_, std::vector<std::uint64_t>(renderers_));
        column.cycles.assign(renderers_, 0);
        column.shown = ColourImage(scenario_.displays.width_pixels, scenario_.displays.height_pixels);
    }
    bad_frames_.clear();
    contributions_frame_ = -1;
    fresh_ = true;
}

void Scoreboard::core_edge() {
    if (reset_i_.read()) {
        if (!fresh_) restart();
        return;
    }
    fresh_ = false;
    const std::int64_t cycle = rtl::clock_edge_number(core_period_picoseconds_);
    for (std::size_t r = 0; r < renderers_; ++r) {
        if (wires_.bus[r].read().kind != rtl::BusBeat::Kind::kNone) take_beat(r, cycle);
    }
    for (std::size_t d = 0; d < displays_; ++d) column_edge(d, cycle);
}

// ---- links and buses ----

void Scoreboard::take_events() {
    for (std::size_t r = 0; r < renderers_; ++r) {
        const rtl::DecoderEvent& event = wires_.event[r].read();
        if (event.pair_good) buses_[r].whole_pairs.insert(event.number);
        if (!link_errs_[r]) continue;
        if (event.colour_start) {
            const Renderer& renderer = scenario_.renderers[r];
            buses_[r].coming =
                std::make_shared<PixelImage>(renderer.image_width_pixels, renderer.image_height_pixels);
        }
        if (event.pair_good) buses_[r].received[event.number] = buses_[r].coming;
    }
}

/// Each pixel has another address than the one before, so none is missed.
void Scoreboard::take_pixels() {
    for (std::size_t r = 0; r < renderers_; ++r) {
        const rtl::DecodedPixel& pixel = wires_.pixel[r].read();
        if (!link_errs_[r] || !pixel.valid || buses_[r].coming == nullptr) continue;
        Pixel& word = buses_[r].coming->values[pixel.address];
        word = pixel.kind == FrameKind::kColour ? with_colour_half(word, pixel.data)
                                                : with_depth_half(word, pixel.data, scenario_.depth_format);
    }
}

void Scoreboard::put_received(functional::Contribution& contribution, std::size_t renderer, int pair) const {
    const auto& received = buses_[renderer].received;
    const auto image = received.find(pair);
    if (image == received.end()) return;
    contribution.copy = image->second;
    contribution.image = contribution.copy.get();
}

void Scoreboard::take_beat(std::size_t r, std::int64_t cycle) {
    Bus& bus = buses_[r];
    const rtl::BusBeat& beat = wires_.bus[r].read();
    const auto wrong_table = [&](const std::string& what) {
        log_.add({"scoreboard/table", rtl::numbered("BUS", r), "core", cycle, bus.frame,
                  what + "; the table is that of pair " + std::to_string(bus.pair)});
    };
    switch (beat.kind) {
        case rtl::BusBeat::Kind::kNone:
            return;
        case rtl::BusBeat::Kind::kFrameStart:
            begin_table(r, cycle);
            break;
        case rtl::BusBeat::Kind::kTableRow:
            if (!bus.known) return;
            if (bus.rows >= bus.contribution.rows.size()) {
                wrong_table("a row too many, " + std::to_string(bus.rows) + " would be right");
                return;
            }
            if (beat.row() != bus.contribution.rows[bus.rows]) {
                wrong_table("row " + std::to_string(bus.rows + 1) + " for display " +
                            std::to_string(beat.row().dcomp) + " is not the valid row of that index");
            }
            ++bus.rows;
            break;
        case rtl::BusBeat::Kind::kPixels:
            check_pixels(r, beat, cycle);
            return;
    }
    if (beat.last && bus.known && bus.rows < bus.contribution.rows.size()) {
        wrong_table("it ends after " + std::to_string(bus.rows) + " rows of " +
                    std::to_string(bus.contribution.rows.size()));
    }
}

void Scoreboard::begin_table(std::size_t r, std::int64_t cycle) {
    Bus& bus = buses_[r];
    const int before = bus.pair;
    ++bus.frame;
    bus.rows = 0;
    bus.reported = false;
    const std::optional<int> pair = pair_of_frame_(r, bus.frame);
    bus.known = pair.has_value();
    if (!bus.known) {
        log_.add({"scoreboard/pair", rtl::numbered("BUS", r), "core", cycle, bus.frame,
                  "a table is broadcast for a frame that has not been started"});
        return;
    }
    bus.pair = *pair;
    if (bus.pair < before || (bus.pair >= 0 && bus.whole_pairs.count(bus.pair) == 0)) {
        log_.add({"scoreboard/pair", rtl::numbered("BUS", r), "core", cycle, bus.frame,
                  "the frame is made of pair " + std::to_string(bus.pair) +
                      (bus.pair < before ? ", the one before of the newer pair " + std::to_string(before)
                                         : ", which the link has not brought whole")});
    }
    bus.whole_pairs.erase(bus.whole_pairs.begin(), bus.whole_pairs.lower_bound(bus.pair));
    // Columns are two frames behind their bus at the most.
    constexpr int kFramesKept = 4;
    if (const std::optional<int> oldest = pair_of_frame_(r, std::max(0, bus.frame - kFramesKept))) {
        bus.received.erase(bus.received.begin(), bus.received.lower_bound(*oldest));
    }
    bus.contribution = reference_.contribution(r, bus.pair);
    put_received(bus.contribution, r, bus.pair);
    bus.row_of_display.assign(displays_, nullptr);
    for (const ViewportRow& row : bus.contribution.rows)
        bus.row_of_display[row.dcomp - std::size_t{1}] = &row;
}

void Scoreboard::check_pixels(std::size_t r, const rtl::BusBeat& beat, std::int64_t cycle) {
    Bus& bus = buses_[r];
    bus_pixels_ += beat.count;
    if (!bus.known || bus.reported || beat.destination < 1 || beat.destination > displays_) return;
    const ViewportRow* const row = bus.row_of_display[beat.destination - std::size_t{1}];
    if (row == nullptr) return;  // the bus monitor checks this
    int x = static_cast<int>(beat.first % row->sdx);
    int y = static_cast<int>(beat.first / row->sdx);
    for (int i = 0; i < beat.count && y < row->sdy; ++i) {
        const Pixel seen(beat.words[static_cast<std::size_t>(i)]);
        const Pixel wanted = reference_.over_the_link(bus.contribution.image->at(row->sx + x, row->sy + y));
        if (seen != wanted) {
            bus.reported = true;
            log_.add({"scoreboard/bus", rtl::numbered("BUS", r), "core", cycle, bus.frame,
                      "pixel " + std::to_string(beat.first + static_cast<std::uint32_t>(i)) +
                          " for display " + std::to_string(beat.destination) + " is " + pixel_text(seen) +
                          " instead of " + pixel_text(wanted) + ", source pixel " +
                          std::to_string(row->sx + x) + "," + std::to_string(row->sy + y) + " of pair " +
                          std::to_string(bus.pair)});
            return;
        }
        if (++x == row->sdx) {
            x = 0;
            ++y;
        }
    }
}

// ---- pipelines ----

void Scoreboard::starved(std::size_t renderer, std::size_t display, const StarvedPixel& pixel) {
    const std::int64_t position = std::int64_t{pixel.y} * raster_width_ + pixel.x;
    columns_[display].starved[std::int64_t{pixel.frame} * raster_pixels_of_frame_ + position].push_back(
        static_cast<int>(renderer));
}

void Scoreboard::column_edge(std::size_t d, std::int64_t cycle) {
    Column& column = columns_[d];
    // The registers hold what they put out at the edge before.
    const bool stood_still = std::exchange(column.stood_still, may_stall_ && wires_.column_stall[d].read());
    if (stood_still) return;
    const std::size_t bottom = renderers_ * displays_ + d;
    if (++column.now == renderers_) column.now = 0;
    std::vector<std::uint64_t>& words = column.words[column.now];
    for (std::size_t r = 0; r < renderers_; ++r) {
        words[r] = wires_.pipe[(r + 1) * displays_ + d].read().pixel.word();
    }
    column.cycles[column.now] = cycle;
    if (!wires_.pipe[bottom].read().valid) return;
    if (column.position == 0) begin_frame(d);
    take_raster_pixel(d, cycle);
    if (++column.position == raster_pixels_of_frame_) {
        column.position = 0;
        end_frame(d);
    }
}

const std::vector<functional::Contribution>& Scoreboard::contributions_of(int frame) {
    if (frame == contributions_frame_) return contributions_;
    contributions_.clear();
    contributions_frame_ = frame;
    std::vector<int> pairs;
    for (std::size_t r = 0; r < renderers_; ++r) {
        const std::optional<int> pair = pair_of_frame_(r, frame);
        if (!pair) return contributions_;
        pairs.push_back(*pair);
    }
    contributions_ = functional::contributions_of(scenario_, pairs);
    for (std::size_t r = 0; r < renderers_; ++r) put_received(contributions_[r], r, pairs[r]);
    compositor_.begin_frame(contributions_);
    return contributions_;
}

void Scoreboard::begin_frame(std::size_t d) {
    Column& column = columns_[d];
    ++column.frame;
    column.reported = false;
    column.known = !contributions_of(column.frame).empty();
    if (column.known) column.raster = compositor_.raster(static_cast<int>(d) + 1);
}

void Scoreboard::take_raster_pixel(std::size_t d, std::int64_t cycle) {
    Column& column = columns_[d];
    const rtl::PipePixel& seen = wires_.pipe[renderers_ * displays_ + d].read();
    std::vector<int> missing;
    if (!column.starved.empty()) {
        const auto entry =
            column.starved.find(std::int64_t{column.frame} * raster_pixels_of_frame_ + column.position);
        if (entry != column.starved.end()) {
            missing = std::move(entry->second);
            column.starved.erase(entry);
        }
    }
    if (!column.known) return;
    const int x = column.position % raster_width_;
    const int y = column.position / raster_width_;
    Pixel& wanted = column.raster.values[static_cast<std::size_t>(column.position)];
    if (!missing.empty()) {
        wanted = reference_.column(contributions_of(column.frame), static_cast<int>(d) + 1, x, y, missing)
                     .bottom();
    }
    if (seen.lost) {
        bad_frames_.insert(column.frame);
        return;
    }
    ++raster_pixels_;
    if (seen.pixel == wanted || column.reported) return;
    column.reported = true;
    const int s = scenario_.displays.supersample;
    Violation violation{"scoreboard/pixel", "", "core", cycle, column.frame, ""};
    const std::string traced = trace_back(
        d, reference_.column(contributions_of(column.frame), static_cast<int>(d) + 1, x, y, missing),
        violation);
    violation.detail = "display " + std::to_string(d + 1) + ", pixel " + std::to_string(x / s) + "," +
                       std::to_string(y / s) + " (raster " + std::to_string(x) + "," + std::to_string(y) +
                       ") is " + pixel_text(seen.pixel) + " instead of " + pixel_text(wanted) + "; " + traced;
    column.wrong[column.frame] = "raster pixel " + std::to_string(x) + "," + std::to_string(y) +
                                 " had left the pipeline wrong, see core clock " +
                                 std::to_string(violation.cycle);
    log_.add(violation);
}

/// Which renderer should have won the pixel that is at the bottom now, which one did, and where it was first wrong:
/// that position goes into the violation.
std::string Scoreboard::trace_back(std::size_t d, const PictureReference::Column& wanted,
                                   Violation& violation) const {
    const Column& column = columns_[d];
    int winner = PictureReference::kBackground;
    std::uint64_t above = scenario_.background_pixel().word();
    std::size_t first_wrong = renderers_ - 1;
    for (std::size_t r = renderers_; r-- > 0;) {
        const std::size_t edge =
            (column.now + r + 1) % renderers_;  // the edge at which composer r put it out
        const std::uint64_t word = column.words[edge][r];
        if (word != wanted.stages[r].word()) first_wrong = r;
    }
    Pixel out;
    std::int64_t cycle = violation.cycle;
    for (std::size_t r = 0; r < renderers_; ++r) {
        const std::size_t edge = (column.now + r + 1) % renderers_;
        const std::uint64_t word = column.words[edge][r];
        if (word != above) winner = static_cast<int>(r);
        above = word;
        if (r == first_wrong) {
            out = Pixel(word);
            cycle = column.cycles[edge];
        }
    }
    violation.signal = rtl::numbered("PIPE", first_wrong + 1, d);
    violation.cycle = cycle;
    std::string text = renderer_text(wanted.winner) + " should have won";
    if (wanted.winning) {
        text += " with source pixel " + std::to_string(wanted.winning->source_x) + "," +
                std::to_string(wanted.winning->source_y) + " of " + pixel_text(wanted.winning->pixel);
    }
    text +=
        ", " + renderer_text(winner) + (winner == wanted.winner ? " did, but with another pixel" : " did");
    const std::string composer = rtl::numbered("composer", first_wrong, d);
    text += "; " + composer + " is the first to be wrong, its PIPE at this clock is " + pixel_text(out) +
            " instead of " + pixel_text(wanted.stages[first_wrong]) +
            "; to be seen with --trace-window cycles:" +
            std::to_string(std::max<std::int64_t>(0, cycle - kClocksAround)) + "-" +
            std::to_string(cycle + kClocksAround) + " --trace-modules " + composer;
    return text;
}

std::string Scoreboard::renderer_text(int renderer) const {
    if (renderer == PictureReference::kBackground) return "the background";
    return "renderer " + std::to_string(renderer + 1) + " (" +
           scenario_.renderers[static_cast<std::size_t>(renderer)].name + ")";
}

std::string Scoreboard::pixel_text(Pixel pixel) const {
    constexpr int kBitsPerDigit = 4;
    const int z_digits = (layout_of(scenario_.depth_format).z_bits + kBitsPerDigit - 1) / kBitsPerDigit;
    return fmt::format("{} A {} Z 0x{:0{}x}", colour_text(pixel.rgb()), pixel.a(), pixel.z(), z_digits);
}

void Scoreboard::end_frame(std::size_t d) {
    Column& column = columns_[d];
    if (column.known) {
        ColourImage& picture = column.pictures[column.frame];
        picture = functional::average_raster(column.raster, scenario_.displays.supersample);
        compositor_.correct_colours(static_cast<int>(d) + 1, picture);
    }
}

// ---- pictures ----

void Scoreboard::shown(const SwapLockMonitor::Shown& shown) {
    Column& column = columns_[shown.display];
    const auto composited = column.pictures.find(shown.frame);
    const auto found = [&](const std::string& what) {
        log_.add({"scoreboard/picture", rtl::numbered("DVI_OUT", shown.display), "dvi_out", shown.dvi_cycle,
                  shown.frame, "display " + std::to_string(shown.display + 1) + what});
    };
    if (composited == column.pictures.end()) {
        found(" shows a frame that has not left its pipeline");
        return;
    }
    const bool kept = bad_frames_.count(shown.frame) > 0;
    if (!kept) column.shown = std::move(composited->second);
    const auto fault = picture_fault(shown.picture, column.shown);
    ++pictures_;
    if (fault) {
        const auto wrong = column.wrong.find(shown.frame);
        found(", " + *fault + "; " +
              (kept ? "pixels of the frame were lost, so the picture before was to stay"
               : wrong == column.wrong.end()
                   ? "the raster left the pipeline right, so it is output_framebuffer_" +
                         std::to_string(shown.display + 1) + " or the swap"
                   : wrong->second));
    }
    column.pictures.erase(column.pictures.begin(), std::next(composited));
    column.wrong.erase(column.wrong.begin(), column.wrong.upper_bound(shown.frame));
}

}  // namespace metabuffer::monitors
