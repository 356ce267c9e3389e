#include "tools/analysis/buffer_case.h"

#include <algorithm>

namespace metabuffer::analysis {
namespace {

/// The least whole number in low..high for which `holds` is true; high if there is none. `holds` must stay true from
/// that number on.
template <typename Holds>
std::int64_t first_where(std::int64_t low, std::int64_t high, Holds holds) {
    while (low < high) {
        const std::int64_t middle = low + (high - low) / 2;
        if (holds(middle)) {
            high = middle;
        } else {
            low = middle + 1;
        }
    }
    return low;
}

}  // namespace

Jobs::Jobs(const BusUser& user, const Portions& portions, const MachineFigures& machine,
           std::int64_t buffer_pixels)
    : segment_(user.segment), portions_(portions), machine_(machine), buffer_pixels_(buffer_pixels) {
    // A composer that is prefetched holds at least this many pixels.
    const std::int64_t held = buffer_pixels - machine.ready_space + 1;
    if (portions.aligned) {
        first_ = (held - 1) / machine.burst_pixels + 1;
    } else {
        const auto behind = std::upper_bound(portions.first_pixel.begin(), portions.first_pixel.end(), held);
        first_ = behind - portions.first_pixel.begin() - 1;
    }
}

/// The composer is not ready for the portion while it holds this pixel. If grants may begin anywhere in a portion, the
/// grant that begins with its last pixel waits longest.
std::int64_t Jobs::waited_for(std::int64_t portion) const {
    const std::int64_t pixel = next_pixel_at_most(portion) - (buffer_pixels_ - portions_.ready_space + 1);
    return std::clamp<std::int64_t>(pixel, 0, segment_.pixels() - 1);
}

std::int64_t Jobs::first_freed_after(std::int64_t position) const {
    return first_where(first_, count(), [&](std::int64_t portion) { return freed_at(portion) > position; });
}

double Jobs::granted_before(std::int64_t portion) const {
    return static_cast<double>(first_pixel(portion)) / static_cast<double>(machine_.burst_pixels);
}

double Jobs::granted_by_room(std::int64_t earlier) const {
    if (portions_.aligned) return granted_before(earlier);
    // What had been released bounds what had been granted.
    return static_cast<double>(buffer_pixels_ + waited_for(earlier)) /
           static_cast<double>(machine_.burst_pixels);
}

std::optional<std::int64_t> Jobs::last_grant_after(std::int64_t portion) const {
    const std::int64_t pixel =
        first_pixel(portion) - machine_.burst_pixels - (buffer_pixels_ - machine_.ready_space) - 1;
    if (pixel < 0) return std::nullopt;
    return segment_.last_use(pixel);
}

double most_refill_pixels(const Segment& segment, const BusTable::SureBursts& sure,
                          const MachineFigures& machine) {
    const std::int64_t pixels = segment.pixels();
    double most = 0.0;
    const auto pass = [&](std::int64_t k) {
        const std::int64_t clocks = machine.raster_pixels - segment.last_use(k) - machine.busready_cycles;
        const double brought =
            sure.in(static_cast<double>(clocks)) * static_cast<double>(machine.burst_pixels);
        most = std::max(most, static_cast<double>(pixels - k) - brought);
    };
    // Between the ends of a source row both sums are straight lines, but for the clock before which the slots are not sure
    // to bring anything. A replicated row's first pixel is an end of its own, since the raster may cut it short.
    const std::int64_t sdx = segment.row().sdx;
    const std::int64_t edge = std::min<std::int64_t>(segment.smooths() ? kUnevenPixels : 2, sdx);
    for (std::int64_t begin = 0; begin < pixels; begin += sdx) {
        for (std::int64_t i = 0; i < edge; ++i) pass(begin + i);
        for (std::int64_t i = edge; i > 0; --i) pass(begin + sdx - i);
    }
    const auto idle_cycles = static_cast<std::int64_t>(sure.loss / sure.rate);
    const std::int64_t position = machine.raster_pixels - idle_cycles - machine.busready_cycles;
    const std::int64_t next = segment.released_before(std::max<std::int64_t>(position, 0));
    for (const std::int64_t k : {next - 1, next}) {
        if (k >= 0 && k < pixels) pass(k);
    }
    return most;
}

std::int64_t RivalGrants::all() const {
    return whole() ? user_.costs.bursts() * burst() : user_.segment.pixels();
}

std::int64_t RivalGrants::of_bursts(std::int64_t bursts) const {
    return std::clamp<std::int64_t>(bursts * burst(), 0, all());
}

std::int64_t RivalGrants::at_most(std::int64_t released) const {
    if (!whole()) return std::min(all(), buffer_pixels_ + released);
    return of_bursts((buffer_pixels_ - table_.machine().ready_space + released) / burst() + 1);
}

std::int64_t RivalGrants::when_full(std::int64_t released) const {
    if (whole()) return at_most(released);
    // "Full" means that there is no room for a whole burst. Once there is room again, its bursts are not cut.
    return std::clamp<std::int64_t>(buffer_pixels_ - table_.machine().uncut_space() + 1 + released, 0, all());
}

std::int64_t RivalGrants::bursts_due_before(std::int64_t position) const {
    return first_where(0, user_.costs.bursts(),
                       [&](std::int64_t b) { return user_.segment.first_use(b * burst()) >= position; });
}

std::int64_t RivalGrants::asked_for(std::int64_t position) const {
    const std::int64_t bursts = bursts_due_by(position);
    if (bursts == 0) return 0;
    return whole() ? of_bursts(bursts) : (bursts - 1) * burst() + 1;
}

std::int64_t RivalGrants::released_before(std::int64_t position) const {
    // The frame's start comes before position 0, and may release pixels that smoothing does not need.
    return position < 0 ? 0
                        : user_.segment.released_before(std::min(position, table_.machine().raster_pixels));
}

double RivalGrants::clocks(std::int64_t pixels) const {
    if (whole()) return user_.costs.before(pixels / burst());
    const double cut = table_.cut_cycles() / static_cast<double>(table_.least_cut_pixels());
    return static_cast<double>(pixels) * (user_.stream.average() / static_cast<double>(burst()) + cut);
}

double RivalGrants::slack() const {
    if (whole()) return 0.0;
    return user_.stream.excess() + 2.0 * user_.stream.average() + 2.0 * table_.cut_cycles();
}

}  // namespace metabuffer::analysis
