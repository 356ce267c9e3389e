#include "tools/analysis/buffer_bound.h"

#include <algorithm>
#include <cmath>
#include <set>

#include "formats/viewport_table.h"
#include "scenario/limits.h"
#include "scenario/link_program.h"
#include "tools/analysis/arithmetic.h"
#include "tools/analysis/starvation_rules.h"

namespace metabuffer::analysis {
/// How long composers take to be prefetched, from the time when each table of a frame is known and the previous frame
/// is composited. From then on a composer is ready until it is prefetched.
class BufferBound::FillTimes {
  public:
    FillTimes(const BufferBound& bound, std::int64_t buffer_pixels)
        : bound_(bound), buffer_pixels_(buffer_pixels), slowest_(bound.displays_), second_(bound.displays_) {
        std::vector<std::vector<double>> of_renderer(bound.renderers_,
                                                     std::vector<double>(bound.displays_, 0.0));
        for (const BusTable& table : bound.tables_) {
            std::vector<double>& longest = of_renderer[static_cast<std::size_t>(table.renderer())];
            for (std::size_t row = 0; row < table.users().size(); ++row) {
                double& clocks = longest[display_index(table, row)];
                clocks = std::max(clocks, fill(table, row));
            }
        }
        for (std::size_t renderer = 0; renderer < bound.renderers_; ++renderer) {
            for (std::size_t display = 0; display < bound.displays_; ++display) {
                const Slowest here{of_renderer[renderer][display], renderer};
                if (here.clocks >= slowest_[display].clocks) {
                    second_[display] = slowest_[display];
                    slowest_[display] = here;
                } else if (here.clocks > second_[display].clocks) {
                    second_[display] = here;
                }
            }
        }
    }

    /// The most clocks by which the column of `rival` starts after that of `row`; both are rows of one table.
    std::int64_t later(const BusTable& table, std::size_t row, std::size_t rival) const {
        // PIPEREADY climbs the column, a clock for each composer, and registers take some clocks. The last beat and the
        // table are on their way for some.
        const double handshakes = as_double(as_int(bound_.renderers_) + bound_.machine_.loop_cycles) + 6.0;
        const double own = std::min(behind(table, row, rival), fill(table, rival));
        const std::size_t display = display_index(table, rival);
        const bool is_slowest = slowest_[display].renderer == static_cast<std::size_t>(table.renderer());
        const double others = is_slowest ? second_[display].clocks : slowest_[display].clocks;
        return static_cast<std::int64_t>(std::ceil(std::max(own, others) + handshakes));
    }

  private:
    struct Slowest {
        double clocks = 0.0;
        std::size_t renderer = 0;
    };

    static std::size_t display_index(const BusTable& table, std::size_t row) {
        return static_cast<std::size_t>(table.users()[row].display()) - 1;
    }

    std::int64_t held_pixels(const BusTable& table, std::size_t row) const {
        return std::min(table.users()[row].segment.pixels(),
                        buffer_pixels_ - table.machine().ready_space + 1);
    }

    /// Bursts that are cut because the buffer is nearly full.
    static std::int64_t cuts(const BusTable& table) {
        const MachineFigures& machine = table.machine();
        if (machine.whole_bursts()) return 0;
        return (machine.uncut_space() - machine.ready_space) / table.least_cut_pixels() + 2;
    }

    std::int64_t grants(const BusTable& table, std::size_t row) const {
        return divide_up(held_pixels(table, row), table.machine().burst_pixels) + cuts(table);
    }

    /// Of the composer's own, for each grant.
    static double grant_cycles(const BusTable& table, std::size_t row) {
        return table.users()[row].costs.longest() + std::max(1.0, table.passed_over_cycles());
    }

    /// Clocks for so many grants.
    static double for_grants(const BusTable& table, std::size_t row, std::int64_t grants) {
        const BusUser& user = table.users()[row];
        const double each = grant_cycles(table, row) + user.wait.rate;
        return table.residual_cycles() + each * as_double(grants) + user.wait.spread;
    }

    double fill(const BusTable& table, std::size_t row) const {
        const double built = table.build_cycles();
        if (table.machine().has_sure_slots()) return built + for_grants(table, row, grants(table, row));
        // The others go first only with what is due before.
        const BusUser& user = table.users()[row];
        const std::int64_t due = user.segment.first_use(held_pixels(table, row) - 1);
        double clocks = table.residual_cycles() +
                        as_double(grants(table, row)) * (grant_cycles(table, row) + user.overrun_cycles);
        for (std::size_t j = 0; j < table.users().size(); ++j) {
            if (j == row) continue;
            const RivalGrants rival(table, j, buffer_pixels_);
            clocks += rival.clocks(rival.of_bursts(rival.bursts_due_by(due) + 1)) + rival.slack();
        }
        return clocks;
    }

    /// The most clocks by which a rival's composer is prefetched after this one, by their own bus alone.
    double behind(const BusTable& table, std::size_t row, std::size_t rival) const {
        const MachineFigures& machine = table.machine();
        if (!machine.has_sure_slots()) {
            const std::int64_t own = divide_up(held_pixels(table, row), machine.burst_pixels);
            const std::int64_t wanted = grants(table, rival);
            const std::int64_t pixel = (own - 1) * machine.burst_pixels;
            const RivalGrants grants(table, rival, buffer_pixels_);
            const std::int64_t had = grants.bursts_due_before(table.users()[row].segment.first_use(pixel));
            const bool done = had >= wanted && !bound_.several_frames_ && machine.loop_cycles == 0;
            return done ? table.residual_cycles() : fill(table, rival);
        }
        const double by_slots = for_grants(table, rival, missing_grants(table, row, rival));
        if (bound_.several_frames_ || !machine.work_conserving()) return by_slots;
        return behind_by_room(table, row, rival, by_slots);
    }

    /// Grants that a rival may still need when the composer of `row` is prefetched.
    std::int64_t missing_grants(const BusTable& table, std::size_t row, std::size_t rival) const {
        const MachineFigures& machine = table.machine();
        const std::int64_t wanted = grants(table, rival);
        std::int64_t missing = wanted - beside(table, row, rival);
        if (bound_.several_frames_) {
            // Or pixels of the previous frame kept it from its slots.
            const auto index = static_cast<std::size_t>(&table - bound_.tables_.data());
            const double pixels = bound_.refills_[index][rival] + as_double(machine.uncut_space());
            const double refill = std::ceil(pixels / as_double(machine.burst_pixels));
            missing = std::max(missing, static_cast<std::int64_t>(refill) + cuts(table));
        }
        return std::clamp<std::int64_t>(missing, 0, wanted);
    }

    /// The least grants that a rival has had when the composer of `row` is prefetched, unless it was full.
    std::int64_t beside(const BusTable& table, std::size_t row, std::size_t rival) const {
        const std::int64_t own = divide_up(held_pixels(table, row), table.machine().burst_pixels);
        const SlotShares::Fairness& fairness = table.rivalry(row, rival).fairness;
        return static_cast<std::int64_t>(
            std::floor(std::max(0.0, fairness.rate * as_double(own) - fairness.loss)));
    }

    /// The same, limited by the others' room. They have had their shares by then. After that they take no more than
    /// what these leave free and what their rasters release meanwhile. Starts with the rival's own clocks, which are
    /// raised until they cover that.
    double behind_by_room(const BusTable& table, std::size_t row, std::size_t rival, double by_slots) const {
        constexpr int kMostSteps = 16;
        const std::int64_t missing = missing_grants(table, row, rival);
        const double own =
            table.residual_cycles() +
            as_double(missing) * (grant_cycles(table, rival) + table.users()[rival].overrun_cycles);
        double clocks = own;
        for (int step = 0; step < kMostSteps; ++step) {
            double raised = own;
            for (std::size_t k = 0; k < table.users().size() && raised < by_slots; ++k) {
                if (k == rival) continue;
                const Rivalry& slots = table.rivalry(rival, k);
                const RivalGrants other(table, k, buffer_pixels_);
                // The other's own column may have started before.
                const double lead = k == row ? 0.0 : for_grants(table, row, missing_grants(table, k, row));
                const auto position = static_cast<std::int64_t>(clocks + lead) + 1;
                const std::int64_t had = std::min(
                    other.when_full(0), k == row ? other.all() : other.of_bursts(beside(table, row, k)));
                const double room = other.clocks(other.at_most(other.released_before(position))) -
                                    other.clocks(had) + other.slack();
                raised +=
                    std::min(slots.slot_rate * as_double(missing) + slots.slot_spread, std::max(0.0, room));
            }
            if (raised <= clocks) return clocks;
            clocks = raised;
            if (clocks >= by_slots) return by_slots;
        }
        return by_slots;
    }

    const BufferBound& bound_;
    std::int64_t buffer_pixels_;
    std::vector<Slowest> slowest_;  ///< by display: the slowest of all renderers
    std::vector<Slowest> second_;   ///< by display: the second slowest
};

BufferBound::BufferBound(const Scenario& scenario, const MachineFigures& machine)
    : machine_(machine),
      renderers_(scenario.renderers.size()),
      displays_(static_cast<std::size_t>(scenario.displays.count())),
      several_frames_(scenario.frames > 1) {
    for (std::size_t r = 0; r < renderers_; ++r) {
        const Renderer& renderer = scenario.renderers[r];
        ViewportLimits limits = scenario.limits(renderer);
        limits.buffer_pixels = static_cast<int>(limits::kBufferPixels.high);
        std::vector<const RendererFrame*> known;
        for (std::size_t frame = 0; frame < renderer.frames.size(); ++frame) {
            // A free-running link may be ahead of the frames, so all entries count.
            if (scenario.pacing == Pacing::kLockstep && frame >= static_cast<std::size_t>(scenario.frames))
                break;
            const RendererFrame& entry = renderer.frames[frame];
            const bool is_known =
                std::any_of(known.begin(), known.end(),
                            [&entry](const RendererFrame* other) { return has_same_tables(*other, entry); });
            if (is_known) continue;
            known.push_back(&entry);
            const ValidatedTable valid = validate_table(entry.table, limits);
            tables_.emplace_back(scenario, machine, static_cast<int>(r), valid.rows,
                                 frame_slots(scenario, renderer, entry, valid).slots);
        }
    }
    refills_.reserve(tables_.size());
    for (const BusTable& table : tables_) {
        std::vector<double>& refills = refills_.emplace_back();
        for (std::size_t row = 0; row < table.users().size(); ++row)
            refills.push_back(refill_pixels(table, row));
    }
}

std::int64_t BufferBound::smallest_legal_pixels() const {
    std::int64_t pixels = 0;
    for (const BusTable& table : tables_) {
        pixels = std::max(pixels, table.machine().ready_space);
        for (const BusUser& user : table.users()) {
            pixels = std::max(pixels, least_buffer_pixels(user.segment.row(), table.machine().smoothing,
                                                          table.machine().ready_space));
        }
    }
    return pixels;
}

std::int64_t BufferBound::whole_segment_pixels() const {
    std::int64_t pixels = smallest_legal_pixels();
    for (const BusTable& table : tables_) {
        for (const BusUser& user : table.users()) {
            pixels = std::max(pixels, user.segment.pixels() + table.machine().ready_space - 1);
        }
    }
    return pixels;
}

/// The most pixels that the raster releases towards the end of any earlier frame, less what the slots are sure to bring
/// meanwhile.
double BufferBound::refill_pixels(const BusTable& table, std::size_t row) const {
    const MachineFigures& machine = table.machine();
    if (!several_frames_) return 0.0;
    if (!machine.has_sure_slots()) return as_double(limits::kBufferPixels.high);
    const BusUser& user = table.users()[row];
    BusTable::SureBursts sure = table.sure_bursts(row);
    sure.loss += sure.rate * table.build_cycles();
    double most = 0.0;
    for (const BusTable& before : tables_) {
        if (before.renderer() != table.renderer()) continue;
        for (const BusUser& old : before.users()) {
            if (old.display() != user.display()) continue;
            most = std::max(most, most_refill_pixels(old.segment, sure, machine));
        }
    }
    return most;
}

BufferCase BufferBound::case_of(RowIndex index, std::int64_t buffer_pixels, const FillTimes& fill) const {
    const BusTable& table = tables_[index.table];
    BufferCase result;
    result.buffer_pixels = buffer_pixels;
    result.follows_a_frame = several_frames_;
    result.refill_pixels = refills_[index.table];
    for (std::size_t j = 0; j < table.users().size(); ++j) {
        ColumnShift shift;
        if (j != index.row && table.knows_rivals())
            shift = {fill.later(table, index.row, j), fill.later(table, j, index.row)};
        result.shifts.push_back(shift);
    }
    return result;
}

std::optional<BufferBound::RowIndex> BufferBound::find_unsafe(std::int64_t buffer_pixels) const {
    const FillTimes fill(*this, buffer_pixels);
    const auto unsafe = [&](RowIndex index) {
        return !is_starvation_free(tables_[index.table], index.row, case_of(index, buffer_pixels, fill));
    };
    if (suspect_ && unsafe(*suspect_)) return suspect_;
    for (std::size_t table = 0; table < tables_.size(); ++table) {
        for (std::size_t row = 0; row < tables_[table].users().size(); ++row) {
            if (unsafe({table, row})) {
                suspect_ = RowIndex{table, row};
                return suspect_;
            }
        }
    }
    return std::nullopt;
}

bool BufferBound::is_safe(std::int64_t buffer_pixels) const {
    return buffer_pixels >= smallest_legal_pixels() && !find_unsafe(buffer_pixels).has_value();
}

/// Searches in strides that double, then bisects between the last two sizes. Safety need not be monotonic, but the size
/// found is safe.
std::optional<BufferBound::Result> BufferBound::find() const {
    if (!machine_.has_bound()) return std::nullopt;
    Result result;
    std::int64_t unsafe = smallest_legal_pixels();
    const std::int64_t largest = whole_segment_pixels();
    std::optional<RowIndex> index = find_unsafe(unsafe);
    if (!index) {
        result.pixels = unsafe;
        return result;
    }
    std::int64_t safe = largest;
    for (std::int64_t stride = 1; unsafe + stride < largest; stride *= 2) {
        const std::int64_t tried = unsafe + stride;
        const std::optional<RowIndex> found = find_unsafe(tried);
        if (!found) {
            safe = tried;
            break;
        }
        unsafe = tried;
        index = found;
    }
    while (safe - unsafe > 1) {
        const std::int64_t tried = unsafe + (safe - unsafe) / 2;
        if (const std::optional<RowIndex> found = find_unsafe(tried)) {
            unsafe = tried;
            index = found;
        } else {
            safe = tried;
        }
    }
    const BusTable& table = tables_[index->table];
    result.pixels = safe;
    result.renderer = table.renderer();
    result.display = table.users()[index->row].display();
    return result;
}

}  // namespace metabuffer::analysis
