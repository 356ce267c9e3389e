#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "tools/analysis/bus_table.h"

namespace metabuffer::analysis {

/// How far apart two columns can start, in clocks: a rival's column at most `later` behind the composer's own and
/// `earlier` before it.
struct ColumnShift {
    std::int64_t later = 0;
    std::int64_t earlier = 0;
};

/// What is known, at one buffer size, of the machine around one composer's row of a table.
struct BufferCase {
    std::int64_t buffer_pixels = 0;
    /// By row of the table: its column against the composer's own.
    std::vector<ColumnShift> shifts;
    /// A frame may have been composited while this one was prefetched.
    bool follows_a_frame = false;
    /// By row: pixels that a composer may lack of a full buffer when it has composited the frame before.
    std::vector<double> refill_pixels;
    /// By row: the most pixels that a table of this renderer sends to its composer.
    std::vector<std::int64_t> largest_segment_pixels;
};

/// A composer's portions as jobs for the bus, at one buffer size. All times are raster positions of its own column: the
/// clock of position p is that of STARTFRAME, one more, and p.
class Jobs {
  public:
    Jobs(const BusUser& user, const Portions& portions, const MachineFigures& machine,
         std::int64_t buffer_pixels);

    std::int64_t count() const { return portions_.count(); }
    /// The first portion that may still have to be granted when the column starts. The composer is prefetched then.
    std::int64_t first() const { return first_; }
    /// The position that makes room for the portion: its last use is that of the pixel which has to go.
    std::int64_t freed_at(std::int64_t portion) const { return segment_.last_use(waited_for(portion)); }
    /// Clocks from a release until the bus knows of it.
    static constexpr std::int64_t kBusreadyCycles = 2;
    double latest_start(std::int64_t portion) const {
        return portions_.latest_start[static_cast<std::size_t>(portion)];
    }
    double own_before(std::int64_t portion) const {
        return portions_.own_before[static_cast<std::size_t>(portion)];
    }
    std::int64_t first_pixel(std::int64_t portion) const {
        return portions_.first_pixel[static_cast<std::size_t>(portion)];
    }
    /// The first portion that no release up to and with `position` makes room for.
    std::int64_t first_freed_after(std::int64_t position) const;
    /// Grants that the composer has had when it waits for `portion`: at least granted_before(portion) since the frame
    /// began, and that less granted_by_room(earlier) since any time at which it had no room for `earlier` yet.
    double granted_before(std::int64_t portion) const;
    double granted_by_room(std::int64_t earlier) const;
    /// A position that was over when the grant before `portion` came; none if it may have come before STARTFRAME.
    std::optional<std::int64_t> last_grant_after(std::int64_t portion) const;
    /// The pixel that a composer which waits for `portion` is to get next, at most and at least.
    std::int64_t next_pixel_at_most(std::int64_t portion) const {
        return portions_.aligned ? first_pixel(portion) : first_pixel(portion + 1) - 1;
    }
    /// First pixel of the grant before `portion`, at least.
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

/// How much of a rival's segment has been granted, at one buffer size, and what that takes of the bus.
class RivalGrants {
  public:
    RivalGrants(const BusTable& table, std::size_t row, std::int64_t buffer_pixels)
        : table_(table), user_(table.users()[row]), buffer_pixels_(buffer_pixels) {}

    /// Pixels, whole bursts where bursts are whole.
    std::int64_t all() const;
    /// At most, once so many pixels have been released.
    std::int64_t at_most(std::int64_t released) const;
    /// At least, if it was not ready when so many had been released.
    std::int64_t when_full(std::int64_t released) const;
    /// Those of `bursts` whole bursts.
    std::int64_t of_bursts(std::int64_t bursts) const;
    /// At least those that the raster has asked for, once it has come to a position.
    std::int64_t asked_for(std::int64_t position) const;
    /// Bursts that begin with a pixel first used before (or at) a position.
    std::int64_t bursts_due_before(std::int64_t position) const;
    std::int64_t bursts_due_by(std::int64_t position) const { return bursts_due_before(position + 1); }
    std::int64_t released_before(std::int64_t position) const;

    /// Clocks for pixels up to `pixels`: the difference of two is what those between them take, with slack() at most
    /// on top.
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
