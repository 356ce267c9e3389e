#include "rtl/bus_port.h"

#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cstdint>
#include <deque>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "lockstep/lockstep.h"
#include "rtl/register.h"
#include "support/images.h"
#include "support/rows.h"
#include "support/scenarios.h"
#include "support/traced_values.h"

namespace metabuffer::test::bus_port_test {
namespace {

using rtl::BusBeat;
using rtl::BusPort;
using rtl::FrontTable;
using rtl::MemoryAnswer;
using rtl::MemoryData;
using rtl::MemoryRequest;

constexpr int kWidth = 16;  ///< of the image
constexpr int kDisplays = 2;

constexpr int kImageHeight = 8;
constexpr int kFrames = 8;  ///< of the scenario: after them the port is done

/// What a port is made with, and what follows from it.
struct Parts {
    Scenario scenario;
    struct OfDut {
        BusCounters counters;
        std::vector<bool> starts;  ///< whether each frame's pair was new
        const BusPort* port = nullptr;
    };
    std::vector<std::unique_ptr<OfDut>> duts;

    const MemoryConfig& memory() const { return scenario.memory; }
    const BusConfig& bus() const { return scenario.bus; }
    int beat_pixels() const { return std::min(std::max(1, bus().width_bits / 64), memory().words_per_cycle); }
    int beat_clocks() const { return std::max(1, 64 / bus().width_bits); }
    int row_clocks() const { return std::max(1, 128 / bus().width_bits); }
    int lost_slot_clocks() const {
        return (bus().burst_pixels + beat_pixels() - 1) / beat_pixels() * beat_clocks();
    }
    int loop() const { return memory().read_latency_cycles + 2 * bus().register_stages; }
    /// The address of the other image's first word.
    int other_image() const {
        return (kWidth * kImageHeight + memory().page_words - 1) / memory().page_words * memory().page_words;
    }
};

enum class State : std::uint8_t { kAsk, kWait, kTable, kSend, kDone };

/// A row of the frame's table, and how many of its pixels have been sent.
struct SentRow {
    ViewportRow row;
    int sent = 0;

    int pixels() const { return row.sdx * row.sdy; }
    bool pending() const { return sent < pixels(); }
    std::size_t composer() const { return row.dcomp - std::size_t{1}; }
    int image_word(int pixel) const { return (row.sy + pixel / row.sdx) * kWidth + row.sx + pixel % row.sdx; }
    std::uint64_t deadline(int raster_width) const {
        const int x = row.dx + sent % row.sdx * row.dmultiple;
        const int y = row.dy + sent / row.sdx * row.dmultiple;
        return static_cast<std::uint64_t>(y) * static_cast<std::uint64_t>(raster_width) +
               static_cast<std::uint64_t>(x);
    }
};

/// A beat that has been decided on: it waits for its words and its clock.
struct Leaving {
    BusBeat beat;
    int words_at = 0;  ///< the clock at which the memory puts them out
    int out_at = 0;    ///< the clock after whose edge it stands on the bus
};

/// Everything that an edge changes. Clocks are counted from the end of reset on.
struct Registers {
    int now = 0;
    State state = State::kAsk;
    bool request = false;
    bool answer_before = false, answer_seen = false;
    int frames = 0;
    bool starts = false;  ///< the frame's start is told to the arbiter
    int image = 0;        ///< which one is read
    std::vector<SentRow> rows;
    int table_start = -1;  ///< the clock of the frame-start beat; none: -1
    int start_before = -1'000;
    bool closing = false;
    // The burst under way.
    int row = -1;
    int burst_left = 0;
    int burst_since = 0;
    int beats = 0;
    std::vector<int> announced;  ///< by the burst, after each edge since burst_since
    // The beat under way.
    BusBeat beat;
    int beat_left = 0;
    int beat_row = -1;
    int beat_words_at = 0;
    bool beat_is_last = false;  ///< its burst has been stopped
    int lost_left = 0;
    std::array<int, kDisplays> passed_over_to{};  ///< the last clock at which a composer is passed over
    std::deque<Leaving> leaving;
    BusBeat bus;
};

/// A bus port by the rules of its header. The test plays the link's side, the composers, the arbiter, and a memory that
/// answers at random and puts out random words.
class Port final : private Parts, public Lockstep<BusPort> {
  public:
    Port(LockstepBench& bench, const char* port_name, const Scenario& made)
        : Parts{made, {}}, Lockstep(bench, port_name, [this](const char* name, rtl::ClockGating) {
              OfDut& of = *duts.emplace_back(std::make_unique<OfDut>());
              auto dut = std::make_unique<BusPort>(
                  name, scenario, scenario.renderers[0], [&of](bool fresh) { of.starts.push_back(fresh); },
                  of.counters);
              of.port = dut.get();
              return dut;
          }) {
        first_.passed_over_to.fill(-1);
        now_ = first_;
        for (std::size_t line = 0; line < kDisplays; ++line) {
            busready_.push_back(&in(&BusPort::busready_i, line));
            tableready_.push_back(&in(&BusPort::tableready_i, line));
            grant_.push_back(&in(&BusPort::grant_i, line));
            pending_.push_back(&out(&BusPort::pending_o, line));
            ready_.push_back(&out(&BusPort::ready_o, line));
            if (bus().arbitration == Arbitration::kEdf) deadline_.push_back(&out(&BusPort::deadline_o, line));
            wires_.add(*busready_.back(), 12);
            wires_.add(*tableready_.back(), 8);
        }
        if (memory().shared()) front_ = &in(&BusPort::front_i, 0);
    }

    void stimulate() override {
        check_counters();
        wires_.stimulate(bench_);
        if (bench_.in_reset()) restart_inputs();
        drive_link();
        drive_arbiter();
        next_ = now_;
        due_before_ = due_;
        request_due_ = MemoryRequest{};
        answer_memory_ = MemoryAnswer{};
        take_due_ = false;
        clock();
        memory_answer_ = answer_memory_;
        drive_memory();
    }
    void expect() override {
        request_ = now_.request;
        bus_ = now_.bus;
        start_ = now_.starts;
        take_ = take_due_;
        memory_request_ = request_due_;
        for (std::size_t line = 0; line < kDisplays; ++line) {
            const bool used = line < now_.rows.size() && now_.rows[line].pending();
            *pending_[line] = used;
            ready_[line]->ignore();
            if (used && now_.state == State::kSend) *ready_[line] = ready(line);
            if (deadline_.empty()) continue;
            deadline_[line]->ignore();
            if (used) *deadline_[line] = now_.rows[line].deadline(scenario.displays.raster_width_pixels());
        }
    }
    void edge() override {
        now_ = next_;
        ++now_.now;
    }
    void reset() override {
        now_ = first_;
        due_ = due_before_;
        ++due_.idle_cycles;
    }

    bool has_register(const std::string& with_value) const { return shows(dut(), with_value); }
    /// Between two edges: registers that a waveform shows and no output.
    void check_registers() const {
        const std::vector<std::string> values = traced_values(dut());
        const auto check = [&](const std::string& name, int largest, int due) {
            const std::string text = dut().name() + ("." + name + "[") +
                                     std::to_string(rtl::bits_for(largest)) + "]=" + std::to_string(due);
            INFO(text << " after clock " << bench_.clock());
            CHECK(std::count(values.begin(), values.end(), text) == 1);
        };
        const int last = *std::max_element(now_.passed_over_to.begin(), now_.passed_over_to.end());
        check("uncounted_cycles", 1 + loop(), std::max(0, last + 1 - now_.now));
        if (now_.row >= 0) check("announced_before", bus().burst_pixels, announced_before());
    }
    void check_starts() const {
        for (const auto& of : duts) CHECK(of->starts == starts_);
        CHECK(first_wrong_counters_ == "");
    }

  private:
    // ---- stimulus ----

    /// True once in so many clocks, in a pause less often.
    bool now_and_then(int clocks) { return bench_.random.one_in(bench_.pausing() ? 6 * clocks : clocks); }

    /// The link's side is reset as well.
    void restart_inputs() { answer_ = false; }
    void drive_link() {
        Random& random = bench_.random;
        const bool asked = now_.state == State::kWait && answer_ == now_.answer_seen;
        if (bench_.in_reset() || !asked || !now_and_then(6)) return;
        answer_ = !answer_;
        fresh_ = random.one_in(2);
        if (front_ != nullptr) *front_ = random.one_in(2);
        FrontTable table;
        std::vector<int> displays{1, 2};
        for (int rows = random.one_in(10) ? 0 : random.between(1, kDisplays); rows > 0; --rows) {
            const auto which = random.between(0, static_cast<int>(displays.size()) - 1);
            const int width = random.between(1, 9);
            const int height = random.between(1, 3);
            const int multiple = random.between(1, 3);
            table.rows.push_back(table_row(
                displays[static_cast<std::size_t>(which)],
                {random.between(0, kWidth - width), random.between(0, kImageHeight - height)},
                {width, height},
                {random.between(0, 64 - multiple * width), random.between(0, 64 - multiple * height)},
                multiple));
            displays.erase(displays.begin() + which);
        }
        table_ = table;
    }
    /// An answer may come whether the bus takes it or not. A table is built at the beginning of a frame.
    void drive_arbiter() {
        Random& random = bench_.random;
        grant_valid_ = false;
        lost_ = false;
        recovered_ = 0;
        for (Input<bool>* grant : grant_) *grant = false;
        if (now_.starts) building_ = random.one_in(3) ? random.between(1, 40) : 0;
        if (bus().grant_cycles > 0 && now_and_then(2)) searching_ = !searching_;
        search_ = building_ > 0 || searching_;
        if (building_ > 0) --building_;
        if (now_.state != State::kSend || search_) return;
        if (bus().arbitration == Arbitration::kSlotAllocation && (lost_clocks_ > 0 || now_and_then(10))) {
            lost_ = true;
            lost_clocks_ = lost_clocks_ > 0   ? lost_clocks_ - 1
                           : random.one_in(6) ? random.between(10, 40)
                                              : 0;
            return;
        }
        std::vector<std::size_t> ready_rows;
        for (std::size_t line = 0; line < now_.rows.size(); ++line) {
            if (ready(line) && now_.rows[line].pending()) ready_rows.push_back(line);
        }
        if (ready_rows.empty() || (bench_.pausing() ? !random.one_in(25) : random.one_in(6))) return;
        const auto which = random.between(0, static_cast<int>(ready_rows.size()) - 1);
        *grant_[ready_rows[static_cast<std::size_t>(which)]] = true;
        grant_valid_ = true;
        recovered_ = static_cast<std::uint16_t>(random.between(0, 3));
    }
    /// The words of the read that was sent `latency` clocks ago.
    void drive_memory() {
        reads_.push_back(bench_.in_reset() ? 0 : answer_memory_.count);
        MemoryData words;
        if (reads_.size() > static_cast<std::size_t>(memory().read_latency_cycles)) {
            words.count = static_cast<std::uint8_t>(reads_.front());
            reads_.pop_front();
        }
        for (std::size_t word = 0; word < words.count; ++word) words.words[word] = bench_.random.bits();
        data_ = words;
        for (Leaving& leaving : next_.leaving) take_words(leaving);
        if (next_.beat_left > 0 && next_.beat_words_at == now_.now) next_.beat.words = words.words;
        put_out();
    }
    void take_words(Leaving& leaving) const {
        if (leaving.beat.kind == BusBeat::Kind::kPixels && leaving.words_at == now_.now) {
            leaving.beat.words = data_->words;
        }
    }
    void put_out() {
        next_.bus = BusBeat{};
        if (!next_.leaving.empty() && next_.leaving.front().out_at == now_.now) {
            next_.bus = next_.leaving.front().beat;
            next_.leaving.pop_front();
        }
    }

    // ---- reference ----

    bool ready(std::size_t line) const {
        const std::size_t composer = now_.rows[line].composer();
        return now_.now > now_.passed_over_to[composer] && *busready_[composer];
    }
    int granted() const {
        for (std::size_t line = 0; line < kDisplays && grant_valid_; ++line) {
            if (*grant_[line]) return static_cast<int>(line);
        }
        return -1;
    }
    SentRow& row(int line) { return next_.rows[static_cast<std::size_t>(line)]; }
    /// The memory is busy for some clocks, or reads some of the words.
    void answer_request() {
        Random& random = bench_.random;
        if (busy_clocks_ == 0 && random.one_in(4)) {
            busy_clocks_ = random.between(1, random.one_in(8) ? 30 : 6);
            busy_with_ = static_cast<MemoryAnswer::Kind>(random.between(
                static_cast<int>(MemoryAnswer::Kind::kOpen), static_cast<int>(MemoryAnswer::Kind::kWrite)));
        }
        if (busy_clocks_ > 0) {
            --busy_clocks_;
            answer_memory_.kind = busy_with_;
        } else {
            answer_memory_.kind = MemoryAnswer::Kind::kRead;
            answer_memory_.count = static_cast<std::uint8_t>(
                random.one_in(4) ? random.between(1, request_due_.count) : request_due_.count);
        }
        const bool of_page = answer_memory_.kind == MemoryAnswer::Kind::kRead ||
                             answer_memory_.kind == MemoryAnswer::Kind::kOpen;
        answer_memory_.miss = of_page && random.one_in(4);
    }

    /// A clock, from the registers now_ to the registers next_.
    void clock() {
        Registers& next = next_;
        next.starts = false;
        const bool answered = now_.answer_before != now_.answer_seen;
        next.answer_before = answer_;
        if (burst_is_stopped()) stop_burst();
        if (now_.closing) {
            next.closing = false;
            request_due_.close = true;
        }
        switch (now_.state) {
            case State::kAsk:
                ++due_.idle_cycles;
                ask();
                break;
            case State::kWait:
                ++due_.idle_cycles;
                if (answered) begin_frame();
                break;
            case State::kTable:
                table_clock();
                break;
            case State::kSend:
                send_clock();
                break;
            case State::kDone:
                ++due_.idle_cycles;
                break;
        }
        if (next.row >= 0) {
            next.announced.push_back(next.beats > 0 && next.beat_left == 0 ? next.burst_left
                                     : next.announced.empty()              ? 0
                                                                           : next.announced.back());
        }
    }
    void ask() {
        if (now_.frames == kFrames) {
            next_.state = State::kDone;
            ++bench_.happened["all frames were sent"];
            return;
        }
        next_.request = !now_.request;
        next_.state = State::kWait;
        next_.closing = !memory().shared();
    }
    void begin_frame() {
        next_.answer_seen = now_.answer_before;
        if (!bench_.in_reset()) starts_.push_back(fresh_);
        ++next_.frames;
        next_.starts = true;
        next_.image = front_ != nullptr && *front_ ? 1 : 0;
        next_.rows.clear();
        for (const ViewportRow& of : table_->rows) next_.rows.push_back({of});
        next_.table_start = -1;
        next_.state = State::kTable;
    }
    void send(const BusBeat& beat, int words_at) {
        next_.leaving.push_back({beat, words_at, now_.now + memory().read_latency_cycles});
    }
    std::uint32_t frame() const { return static_cast<std::uint32_t>(now_.frames - 1); }
    void table_clock() {
        const auto rows = static_cast<int>(now_.rows.size());
        if (now_.table_start < 0) {
            bool taken = loop() == 0 || now_.now >= now_.start_before + 2 + loop();
            for (const Input<bool>* tableready : tableready_) taken = taken && *tableready;
            if (!taken) {
                ++due_.poll_cycles;
                return;
            }
            next_.table_start = next_.start_before = now_.now;
            send(BusBeat::frame_start(frame(), rows == 0), 0);
        } else if ((now_.now - now_.table_start) % row_clocks() == 0) {
            const int index = (now_.now - now_.table_start) / row_clocks() - 1;
            send(BusBeat::table_row(frame(), static_cast<std::uint32_t>(index), row(index).row,
                                    index == rows - 1),
                 0);
        }
        ++due_.table_cycles;
        if (now_.now == next_.table_start + rows * row_clocks()) next_.state = State::kSend;
    }

    /// A low BUSREADY answers the beat that stood on the bus so many clocks ago. It stops the burst if more than a beat
    /// was announced with that beat.
    bool burst_is_stopped() {
        return now_.row >= 0 && announced_before() > beat_pixels() && !*busready_[row(now_.row).composer()];
    }
    int announced_before() const {
        const int answers = now_.now - 2 - loop() - now_.burst_since;
        return answers < 0 ? 0 : now_.announced.at(static_cast<std::size_t>(answers));
    }
    void stop_burst() {
        ++bench_.happened["a burst was stopped"];
        request_due_.give_up = now_.state == State::kSend;
        const std::size_t composer = row(next_.row).composer();
        if (loop() > 0) next_.passed_over_to[composer] = now_.now + loop();
        next_.beat_is_last = next_.beat_left > 0;
        next_.burst_left = 0;
        next_.row = -1;
    }
    void send_clock() {
        if (now_.beat_left > 0) {
            ++due_.busy_cycles;
            if (--next_.beat_left == 0) drive_beat();
            return;
        }
        if (now_.lost_left > 0) {
            ++due_.lost_cycles;
            --next_.lost_left;
            return;
        }
        if (next_.row < 0 && !take_answer()) return;
        ask_for_words();
        answer_request();
        due_.page_misses += answer_memory_.miss ? 1 : 0;
        switch (answer_memory_.kind) {
            case MemoryAnswer::Kind::kOpen:
                ++due_.page_miss_cycles;
                break;
            case MemoryAnswer::Kind::kRefresh:
                ++due_.refresh_cycles;
                break;
            case MemoryAnswer::Kind::kWrite:
                ++due_.write_cycles;
                break;
            default:
                ++due_.busy_cycles;
                read(answer_memory_.count);
        }
    }
    bool take_answer() {
        if (std::none_of(now_.rows.begin(), now_.rows.end(),
                         [](const SentRow& of) { return of.pending(); })) {
            ++due_.idle_cycles;
            ask();
            return false;
        }
        take_due_ = true;
        if (lost_) {
            ++due_.lost_cycles;
            next_.lost_left = lost_slot_clocks() - 1;
            return false;
        }
        next_.row = granted();
        if (next_.row < 0) {
            ++(search_ ? due_.grant_cycles : due_.poll_cycles);
            return false;
        }
        due_.recovered_slots += recovered_;
        ++due_.bursts;
        next_.burst_since = now_.now;
        next_.announced.clear();
        next_.beats = 0;
        next_.burst_left = std::min(bus().burst_pixels, row(next_.row).pixels() - row(next_.row).sent);
        return true;
    }
    /// As many as fit the beat and the burst.
    void ask_for_words() {
        const SentRow& of = row(next_.row);
        while (request_due_.count < std::min(beat_pixels(), next_.burst_left)) {
            request_due_.addresses[request_due_.count] = static_cast<std::uint32_t>(
                next_.image * other_image() + of.image_word(of.sent + request_due_.count));
            ++request_due_.count;
        }
    }
    void read(int words) {
        SentRow& of = row(next_.row);
        next_.beat = BusBeat{};
        next_.beat.kind = BusBeat::Kind::kPixels;
        next_.beat.frame = frame();
        next_.beat.destination = of.row.dcomp;
        next_.beat.first = static_cast<std::uint32_t>(of.sent);
        next_.beat.count = static_cast<std::uint8_t>(words);
        of.sent += words;
        next_.burst_left -= words;
        due_.pixels_sent += words;
        next_.beat_words_at = now_.now + memory().read_latency_cycles;
        next_.beat_row = next_.row;
        next_.beat_left = beat_clocks() - 1;
        if (next_.beat_left == 0) drive_beat();
    }
    /// The beat's last clock.
    void drive_beat() {
        next_.beat.remaining = static_cast<std::uint32_t>(next_.burst_left);
        send(next_.beat, next_.beat_words_at);
        ++next_.beats;
        if (next_.burst_left > 0) return;
        if (next_.beats == 1 || next_.beat_is_last || loop() > 0) {
            next_.passed_over_to[row(next_.beat_row).composer()] = now_.now + 1 + loop();
        }
        next_.beat_is_last = false;
        next_.row = -1;
    }

    /// Between two edges: the counters of the clocks before, a sleeping port's too.
    void check_counters() {
        for (const auto& of : duts) {
            BusCounters counted = of->counters;
            of->port->count_slept_cycles(counted);
            if (all_of(counted) != all_of(due_) && first_wrong_counters_.empty()) {
                first_wrong_counters_ = of->port->name() + (" at clock " + std::to_string(bench_.clock()));
            }
        }
    }
    static std::array<std::int64_t, 13> all_of(const BusCounters& of) {
        return {of.busy_cycles,  of.table_cycles, of.page_miss_cycles, of.refresh_cycles, of.write_cycles,
                of.grant_cycles, of.poll_cycles,  of.lost_cycles,      of.idle_cycles,    of.page_misses,
                of.pixels_sent,  of.bursts,       of.recovered_slots};
    }

    Output<bool>& request_ = out(&BusPort::request_o);
    Input<bool>& answer_ = in(&BusPort::answer_i);
    Input<bool>& fresh_ = in(&BusPort::fresh_i);
    Input<FrontTable>& table_ = in(&BusPort::table_i);
    Input<bool>* front_ = nullptr;
    Output<BusBeat>& bus_ = out(&BusPort::bus_o);
    std::vector<Input<bool>*> busready_, tableready_, grant_;
    Output<bool>& start_ = out(&BusPort::start_o);
    Output<bool>& take_ = out(&BusPort::take_o);
    std::vector<Output<bool>*> pending_, ready_;
    std::vector<Output<std::uint64_t>*> deadline_;
    Input<bool>& grant_valid_ = in(&BusPort::grant_valid_i);
    Input<bool>& search_ = in(&BusPort::search_i);
    Input<bool>& lost_ = in(&BusPort::lost_i);
    Input<std::uint16_t>& recovered_ = in(&BusPort::recovered_i);
    Output<MemoryRequest>& memory_request_ = out(&BusPort::memory_o);
    Input<MemoryAnswer>& memory_answer_ = in(&BusPort::memory_i);
    Input<MemoryData>& data_ = in(&BusPort::data_i);
    FreeWires wires_;
    // The test's parts around the port.
    int building_ = 0;  ///< clocks until the arbiter's table is built
    bool searching_ = false;
    int lost_clocks_ = 0;  ///< for which it goes on to report lost slots
    int busy_clocks_ = 0;  ///< for which the memory goes on to read nothing
    MemoryAnswer::Kind busy_with_ = MemoryAnswer::Kind::kNone;
    std::deque<int> reads_;  ///< words, by clock
    // The reference.
    Registers first_, now_ = first_, next_ = first_;
    BusCounters due_, due_before_;
    std::vector<bool> starts_;
    MemoryRequest request_due_;
    MemoryAnswer answer_memory_;
    bool take_due_ = false;
    std::string first_wrong_counters_;
};

/// width_bits, words_per_cycle, burst_pixels.
Scenario port_scenario(int width, int words, int burst) {
    Scenario scenario = small_scenario(64, 64, kDisplays);
    scenario.frames = kFrames;
    scenario.bus.arbitration = Arbitration::kRoundRobin;
    scenario.bus.width_bits = width;
    scenario.bus.burst_pixels = burst;
    scenario.memory.words_per_cycle = words;
    scenario.memory.page_words = 24;  // the other image begins with a page of its own
    scenario.renderers.push_back(renderer_of({PixelImage(kWidth, kImageHeight)}));
    return scenario;
}

std::map<std::string, Scenario> port_scenarios() {
    std::map<std::string, Scenario> all{
        {"plain", port_scenario(128, 2, 8)},  {"one_word", port_scenario(64, 1, 3)},
        {"narrow", port_scenario(16, 1, 4)},  {"half", port_scenario(32, 1, 8)},
        {"wide", port_scenario(512, 8, 20)},  {"deadlines", port_scenario(256, 3, 9)},
        {"losing", port_scenario(128, 2, 8)}, {"losing_beats", port_scenario(128, 2, 2)},
        {"shared", port_scenario(128, 2, 16)}};
    all["deadlines"].bus.arbitration = Arbitration::kEdf;
    all["losing"].bus.arbitration = Arbitration::kSlotAllocation;
    all["losing_beats"].bus.arbitration = Arbitration::kSlotAllocation;  // a lost slot takes a clock
    all["shared"].memory.ports = MemoryPorts::kShared;
    Scenario& late = all["late"] = port_scenario(128, 2, 16);
    late.memory.read_latency_cycles = 3;
    late.bus.register_stages = 2;
    Scenario& narrow_late = all["narrow_late"] = port_scenario(32, 2, 12);
    narrow_late.memory.read_latency_cycles = 2;
    narrow_late.bus.grant_cycles = 2;
    return all;
}

TEST_CASE("bus port: in lockstep with its reference") {
    LockstepBench bench(2741);
    bench.clocks_to_reset = 900;
    std::vector<std::unique_ptr<Port>> ports;
    for (const auto& [name, scenario] : port_scenarios()) {
        ports.push_back(std::make_unique<Port>(bench, name.c_str(), scenario));
    }
    std::size_t port = 0;
    const auto check = [&] { ports[++port % ports.size()]->check_registers(); };
    bench.run(10'000, 20, check, {{"a burst was stopped", 250}, {"all frames were sent", 10}});
    for (const auto& each : ports) each->check_starts();
}

TEST_CASE("bus port: its registers are as many as displays need, and as wide as their largest values") {
    LockstepBench bench;
    const Port port(bench, "port", port_scenario(128, 2, 8));
    const Port late(bench, "late", port_scenarios().at("late"));
    bench.run(1);
    CHECK(port.has_register("row_2_left[8]=0"));
    CHECK_FALSE(port.has_register("row_3_left[8]=0"));
    CHECK(port.has_register("uncounted_2[1]=0"));
    CHECK_FALSE(port.has_register("uncounted_3[1]=0"));
    CHECK(late.has_register("uncounted_1[4]=0"));  // 1 and a loop of 7 clocks
    CHECK(late.has_register("uncounted_cycles[4]=0"));
}

}  // namespace
}  // namespace metabuffer::test::bus_port_test
