#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "tools/analysis/bus_table.h"

namespace metabuffer::analysis {

/// How far apart two columns can start, in clocks: a rival's column at most `later` after the composer's own, or
/// `earlier` before it.
struct ColumnShift {
    std::int64_t later = 0;
    std::int64_t earlier = 0;
};

/// What is known of the machine around the composer of one table row, at one buffer size.
struct BufferCase {
    std::int64_t buffer_pixels = 0;
    /// By row of the table: how far apart its column and the composer's own can start.
    std::vector<ColumnShift> shifts;
    /// A frame may have been composited while this one was prefetched.
    bool follows_a_frame = false;
    /// By row: the most pixels that a composer's buffer may lack to be full when it has composited the previous frame.
    std::vector<double> refill_pixels;
};

/// A composer's portions as jobs for the bus, at one buffer size. All times are raster positions of its own column. The
/// clock of position p is p + 1 clocks after that of STARTFRAME.
class Jobs {
  public:
    Jobs(const BusUser& user, const Portions& portions, const MachineFigures& machine,
         std::int64_t buffer_pixels);

    std::int64_t count() const { return portions_.count(); }
    /// The first portion that may still have to be granted when the column starts. The composer is prefetched then.
    std::int64_t first() const { return first_; }
    /// The position that makes room for the portion: the last use of the pixel that must leave the buffer for it.
    std::int64_t freed_at(std::int64_t portion) const { return segment_.last_use(waited_for(portion)); }
    /// The first clock in which the arbiter can know that there is room for the portion, as a position.
    std::int64_t ready_at(std::int64_t portion) const { return freed_at(portion) + machine_.busready_cycles; }
    double latest_start(std::int64_t portion) const {
        return portions_.latest_start[static_cast<std::size_t>(portion)];
    }
    double own_before(std::int64_t portion) const {
        return portions_.own_before[static_cast<std::size_t>(portion)];
    }
    std::int64_t first_pixel(std::int64_t portion) const {
        return portions_.first_pixel[static_cast<std::size_t>(portion)];
    }
    /// The first portion that still has no room after the releases up to `position`, that one included.
    std::int64_t first_freed_after(std::int64_t position) const;
    /// The least grants that the composer has had when it waits for `portion`: granted_before(portion) since the frame
    /// began. Since any time at which it had no room for `earlier` yet, that less granted_by_room(earlier).
    double granted_before(std::int64_t portion) const;
    double granted_by_room(std::int64_t earlier) const;
    /// A position that had passed when the grant before `portion` came. Empty if that may have come before STARTFRAME.
    std::optional<std::int64_t> last_grant_after(std::int64_t portion) const;
    /// The last pixel that can be the next one of a composer that waits for `portion`.
    std::int64_t next_pixel_at_most(std::int64_t portion) const {
        return portions_.aligned ? first_pixel(portion) : first_pixel(portion + 1) - 1;
    }
    /// The first pixel that the grant before `portion` can have begun with.
    std::int64_t last_grant_pixel(std::int64_t portion) const {
        return std::max<std::int64_t>(0, first_pixel(portion) - machine_.burst_pixels);
    }
    const Segment& segment() const { return segment_; }

  private:
    std::int64_t waited_for(std::int64_t portion) const;

    const Segment& segment_;
    const Portions& portions_;
    const MachineFigures& machine_;
    std::int64_t buffer_pixels_;
    std::int64_t first_ = 0;
};

/// The most pixels by which a composer's buffer can be short of full when it has composited a frame: what the raster of
/// `segment` has released up to its end, from any pixel on, less what the slots are sure to have brought meanwhile.
double most_refill_pixels(const Segment& segment, const BusTable::SureBursts& sure,
                          const MachineFigures& machine);

/// How much of a rival's segment has been granted, at one buffer size, and the bus clocks that this takes.
class RivalGrants {
  public:
    RivalGrants(const BusTable& table, std::size_t row, std::int64_t buffer_pixels)
        : table_(table), user_(table.users()[row]), buffer_pixels_(buffer_pixels) {}

    /// The segment's pixels; if bursts are never cut, rounded up to whole bursts, as all granted pixels here.
    std::int64_t all() const;
    /// The most pixels granted once `released` pixels have been released.
    std::int64_t at_most(std::int64_t released) const;
    /// The least pixels granted if the rival was not ready when `released` pixels had been released.
    std::int64_t when_full(std::int64_t released) const;
    /// The pixels of so many whole bursts.
    std::int64_t of_bursts(std::int64_t bursts) const;
    /// The least pixels granted once the raster has come to `position`: those that it has asked for.
    std::int64_t asked_for(std::int64_t position) const;
    /// How many bursts begin with a pixel that is first used before `position` (bursts_due_by: or at it).
    std::int64_t bursts_due_before(std::int64_t position) const;
    std::int64_t bursts_due_by(std::int64_t position) const { return bursts_due_before(position + 1); }
    std::int64_t released_before(std::int64_t position) const;

    /// Clocks for the first `pixels` pixels. The difference of two such results, plus at most slack(), is what the
    /// pixels between them take.
    double clocks(std::int64_t pixels) const;
    double slack() const;

  private:
    bool whole() const { return table_.machine().whole_bursts(); }
    std::int64_t burst() const { return table_.machine().burst_pixels; }

    const BusTable& table_;
    const BusUser& user_;
    std::int64_t buffer_pixels_;
};

}  // namespace metabuffer::analysis
