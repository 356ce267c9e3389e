#include "tools/charts/run_record.h"

#include <algorithm>
#include <string>

#include "report/counters.h"
#include "tools/charts/base64.h"
#include "tools/charts/page_template.h"

namespace metabuffer::charts {
namespace {

std::string packed(const NumberLog& log) { return base64(deflated(log.bytes())); }

/// Takes one from `left`. False if none is left.
bool take_one(std::size_t& left) {
    if (left == 0) return false;
    --left;
    return true;
}

/// The names of the counters of all uses, in the order of BusUse.
Json bus_uses_json() {
    Json names = Json::array();
    for (const BusUseTraits& use : kBusUseTable) {
        for (const Counter<BusCounters>& counter : Counters<BusCounters>::kTable) {
            if (counter.member == use.counter) names.push_back(counter.name);
        }
    }
    return names;
}

Json span_json(const CycleSpan& span) { return Json::array({span.first, span.last}); }

}  // namespace

// ---- bins ----

void ClockBins::add(std::size_t use, CycleSpan span) {
    while (span.last / width_cycles_ >= static_cast<std::int64_t>(kMost)) {
        for (std::size_t n = 0; n < bins_.size(); ++n) {
            const std::array<std::int64_t, kBusUses> from = std::exchange(bins_[n], {});
            for (std::size_t u = 0; u < kBusUses; ++u) bins_[n / 2][u] += from[u];
        }
        bins_.resize((bins_.size() + 1) / 2);
        width_cycles_ *= 2;
    }
    const auto last_bin = static_cast<std::size_t>(span.last / width_cycles_);
    if (bins_.size() <= last_bin) bins_.resize(last_bin + 1);
    for (std::int64_t cycle = span.first; cycle <= span.last;) {
        const std::int64_t bin = cycle / width_cycles_;
        const std::int64_t next = std::min(span.last + 1, (bin + 1) * width_cycles_);
        bins_[static_cast<std::size_t>(bin)][use] += next - cycle;
        cycle = next;
    }
}

void LevelBins::widen(std::int64_t cycle) {
    while (cycle / width_cycles_ >= static_cast<std::int64_t>(ClockBins::kMost)) {
        for (std::size_t n = 0; n < bins_.size(); n += 2) {
            const std::pair<int, int> other = n + 1 < bins_.size() ? bins_[n + 1] : bins_[n];
            bins_[n / 2] = {std::min(bins_[n].first, other.first), std::max(bins_[n].second, other.second)};
        }
        bins_.resize((bins_.size() + 1) / 2);
        width_cycles_ *= 2;
    }
}

/// Between two points the level changes linearly.
void LevelBins::add(std::int64_t cycle, int level) {
    const std::int64_t from = std::min(last_cycle_, cycle);
    widen(cycle);
    const auto last_bin = static_cast<std::size_t>(cycle / width_cycles_);
    const auto level_at = [&](std::int64_t at) {
        if (cycle == from) return level;
        return last_level_ + static_cast<int>((level - last_level_) * (at - from) / (cycle - from));
    };
    for (auto bin = static_cast<std::size_t>(from / width_cycles_); bin <= last_bin; ++bin) {
        const auto first = static_cast<std::int64_t>(bin) * width_cycles_;
        const int begin = level_at(std::max(first, from));
        const int end = level_at(std::min(first + width_cycles_ - 1, cycle));
        const auto [least, most] = std::minmax(begin, end);
        if (bin < bins_.size()) {
            bins_[bin] = {std::min(bins_[bin].first, least), std::max(bins_[bin].second, most)};
        } else {
            bins_.resize(bin, {begin, begin});
            bins_.emplace_back(least, most);
        }
    }
    last_cycle_ = cycle;
    last_level_ = level;
}

// ---- events of the run ----

RunRecord::RunRecord(const Scenario& scenario, const RecordLimits& limits)
    : displays_(static_cast<std::size_t>(scenario.displays.count())), room_(limits) {
    const std::size_t renderers = scenario.renderers.size();
    buses_.resize(renderers);
    links_.resize(renderers);
    levels_.resize(renderers * displays_);
    starved_.resize(renderers * displays_);
    stalls_.resize(displays_);
}

void RunRecord::bus(int renderer, const tlm::BusSpan& span) {
    BusTrack& track = buses_[static_cast<std::size_t>(renderer - 1)];
    track.bins.add(static_cast<std::size_t>(span.use), span.cycles);
    if (!take_one(room_.bus_spans)) {
        ++track.left_out;
        return;
    }
    ++track.count;
    const auto add = [&track](auto number) { track.spans.add(static_cast<std::uint64_t>(number)); };
    add(span.use);
    track.spans.add_signed(span.cycles.first - track.end);
    add(span.cycles.cycles());
    track.end = track.known = span.cycles.last + 1;
    if (span.use == BusUse::kTable) add(span.frame);
    if (span.use == BusUse::kBusy || span.use == BusUse::kPageMiss) add(span.display);
    if (span.use == BusUse::kBusy) {
        add(span.pixels);
        add(span.recovered_slots);
    }
}

void RunRecord::buffer_level(int renderer, int display, std::int64_t cycle, int held_pixels) {
    LevelTrack& track = levels_[composer(renderer, display)];
    track.bins.add(cycle, held_pixels);
    if (!take_one(room_.level_points)) {
        ++track.left_out;
        return;
    }
    ++track.count;
    track.points.add_signed(cycle - track.cycle);
    track.points.add_signed(held_pixels - track.level);
    track.cycle = track.known = cycle;
    track.level = held_pixels;
}

void RunRecord::composited(int display, int frame, CycleSpan span) {
    const auto f = static_cast<std::size_t>(frame);
    if (composited_.size() <= f) composited_.resize(f + 1, std::vector<CycleSpan>(displays_));
    composited_[f][static_cast<std::size_t>(display - 1)] = span;
}

void RunRecord::column_stall(int display, int frame, CycleSpan span) {
    StallTrack& track = stalls_[static_cast<std::size_t>(display - 1)];
    if (!take_one(room_.stalls)) {
        ++track.left_out;
        return;
    }
    ++track.count;
    track.spans.add_signed(span.first - track.end);
    track.spans.add(static_cast<std::uint64_t>(span.cycles()));
    track.spans.add(static_cast<std::uint64_t>(frame));
    track.end = span.last + 1;
}

void RunRecord::shown(int /*display*/, int frame, CycleSpan span) {
    const auto f = static_cast<std::size_t>(frame);
    if (shown_.size() <= f) shown_.resize(f + 1);
    shown_[f] = span;
}

void RunRecord::link_frame(int renderer, const tlm::LinkFrameSeen& frame) {
    LinkTrack& track = links_[static_cast<std::size_t>(renderer - 1)];
    if (!take_one(room_.link_frames)) {
        ++track.left_out;
        return;
    }
    const char* const kind = !frame.kind                         ? "unreadable"
                             : *frame.kind == FrameKind::kColour ? "colour"
                                                                 : "depth";
    track.frames.push_back(
        Json::array({frame.span.first, frame.span.last, kind, frame.kind ? Json(frame.pair) : Json(),
                     frame.taken, frame.cause ? Json(reject_cause_key(*frame.cause)) : Json()}));
}

void RunRecord::starved(int renderer, int display, const StarvedRun& run) {
    RunTrack& track = starved_[composer(renderer, display)];
    if (!take_one(room_.starved_runs)) {
        ++track.left_out;
        return;
    }
    ++track.count;
    track.runs.add_signed(run.frame - track.last.frame);
    track.runs.add_signed(run.y - track.last.y);
    track.runs.add_signed(run.x_first - track.last.x_first);
    track.runs.add(static_cast<std::uint64_t>(run.x_last - run.x_first));
    track.last = run;
}

// ---- what the page reads ----

Json RunRecord::json() const {
    Json json;
    json["bus_uses"] = bus_uses_json();
    // The page draws bins where single spans and points are left out.
    json["buses"] = Json::array();
    for (const BusTrack& track : buses_) {
        Json bus = {{"count", track.count}, {"spans", packed(track.spans)}, {"left_out", track.left_out}};
        if (track.left_out > 0) {
            NumberLog bins;
            for (const auto& bin : track.bins.bins()) {
                for (const std::int64_t cycles : bin) bins.add(static_cast<std::uint64_t>(cycles));
            }
            bus["known_cycles"] = track.known;
            bus["bin_cycles"] = track.bins.width_cycles();
            bus["bins"] = packed(bins);
        }
        json["buses"].push_back(std::move(bus));
    }
    json["levels"] = Json::array();
    for (const LevelTrack& track : levels_) {
        Json level = {{"count", track.count}, {"points", packed(track.points)}, {"left_out", track.left_out}};
        if (track.left_out > 0) {
            NumberLog bins;
            for (const auto& [least, most] : track.bins.bins()) {
                bins.add(static_cast<std::uint64_t>(std::max(0, least)));
                bins.add(static_cast<std::uint64_t>(std::max(0, most)));
            }
            level["known_cycles"] = track.known;
            level["bin_cycles"] = track.bins.width_cycles();
            level["bins"] = packed(bins);
        }
        json["levels"].push_back(std::move(level));
    }
    // The page reads all of them when it opens, so they are one text.
    Json counts = Json::array();
    std::string runs;
    std::int64_t runs_left_out = 0;
    for (const RunTrack& track : starved_) {
        counts.push_back(track.count);
        runs += track.runs.bytes();
        runs_left_out += track.left_out;
    }
    json["starved"] = {
        {"counts", std::move(counts)}, {"runs", base64(deflated(runs))}, {"left_out", runs_left_out}};
    json["stalls"] = Json::array();
    for (const StallTrack& track : stalls_) {
        json["stalls"].push_back(
            {{"count", track.count}, {"spans", packed(track.spans)}, {"left_out", track.left_out}});
    }
    json["links"] = Json::array();
    for (const LinkTrack& track : links_) {
        json["links"].push_back({{"frames", track.frames}, {"left_out", track.left_out}});
    }
    json["composited"] = Json::array();
    for (const auto& frame : composited_) {
        Json spans = Json::array();
        for (const CycleSpan& span : frame) spans.push_back(span_json(span));
        json["composited"].push_back(std::move(spans));
    }
    json["shown"] = Json::array();
    for (const CycleSpan& span : shown_) json["shown"].push_back(span_json(span));
    return json;
}

}  // namespace metabuffer::charts
