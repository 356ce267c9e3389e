#include "tools/analysis/task_table.h"

#include <algorithm>
#include <cstddef>
#include <numeric>
#include <utility>

#include "datapath/segment.h"

namespace metabuffer::analysis {
namespace {

/// A task while it is put together.
struct Draft {
    Task task;
    int column = 0;  ///< of displays
    int band = 0;    ///< how many tasks of its column came before
    std::vector<Segment> segments;
    std::size_t number = 0;
    std::size_t letter = 0;
};

bool rows_overlap(const Segment& a, const Segment& b) { return a.top() < b.bottom() && b.top() < a.bottom(); }
bool columns_overlap(const Segment& a, const Segment& b) {
    return a.left() < b.right() && b.left() < a.right();
}

/// Whether a segment can be one more destination of the task.
bool continues(const Draft& draft, const Segment& segment) {
    const Segment& first = draft.segments.front();
    const bool same_columns = first.left() == segment.left() && first.right() == segment.right() &&
                              first.row().sdx == segment.row().sdx &&
                              first.row().dmultiple == segment.row().dmultiple;
    return same_columns && std::none_of(draft.segments.begin(), draft.segments.end(),
                                        [&](const Segment& other) { return rows_overlap(other, segment); });
}

std::vector<Draft> drafts_of(const ViewportTable& rows, int raster_width, int raster_height,
                             int display_columns) {
    // Displays go down each column of the wall, one column after the other.
    std::vector<std::size_t> order(rows.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    const auto position = [&](std::size_t index) {
        const int display = rows[index].dcomp - 1;
        return std::pair(display % display_columns, display / display_columns);
    };
    std::sort(order.begin(), order.end(),
              [&](std::size_t a, std::size_t b) { return position(a) < position(b); });

    std::vector<Draft> drafts;
    for (const std::size_t index : order) {
        const ViewportRow& row = rows[index];
        const Segment segment(row, raster_width, raster_height);
        const int column = position(index).first;
        int band = 0;
        Draft* found = nullptr;
        for (Draft& draft : drafts) {
            if (draft.column != column) continue;
            ++band;
            if (found == nullptr && continues(draft, segment)) found = &draft;
        }
        if (found == nullptr) {
            Draft draft;
            draft.column = column;
            draft.band = band;
            draft.task.data_pixels = row.sdx;
            draft.task.period_cycles = std::int64_t{row.dmultiple} * raster_width;
            draft.task.deadline_cycles = draft.task.period_cycles;
            drafts.push_back(std::move(draft));
            found = &drafts.back();
        }
        found->segments.push_back(segment);
        found->task.displays.push_back(row.dcomp);
    }
    return drafts;
}

/// Tasks of one band and one period that lie next to each other get one number: in each clock at most one of them needs
/// a pixel.
void number_tasks(std::vector<Draft>& drafts) {
    std::stable_sort(drafts.begin(), drafts.end(),
                     [](const Draft& a, const Draft& b) { return a.band < b.band; });
    std::size_t numbers = 0;
    for (std::size_t i = 0; i < drafts.size(); ++i) {
        Draft& draft = drafts[i];
        const auto shares = [&](std::size_t number) {
            bool same_kind = false;
            for (std::size_t k = 0; k < i; ++k) {
                if (drafts[k].number != number) continue;
                if (columns_overlap(drafts[k].segments.front(), draft.segments.front())) return false;
                same_kind =
                    drafts[k].band == draft.band && drafts[k].task.period_cycles == draft.task.period_cycles;
            }
            return same_kind;
        };
        std::size_t number = 1;
        while (number <= numbers && !shares(number)) ++number;
        draft.number = number;
        draft.letter = static_cast<std::size_t>(
            std::count_if(drafts.begin(), drafts.begin() + static_cast<std::ptrdiff_t>(i),
                          [number](const Draft& other) { return other.number == number; }));
        numbers = std::max(numbers, number);
    }
}

/// 0 is "a", 26 is "aa".
std::string letters(std::size_t index) {
    constexpr std::size_t kLetters = 26;
    std::string text(1, static_cast<char>('a' + index % kLetters));
    return index < kLetters ? text : letters(index / kLetters - 1) + text;
}

}  // namespace

std::vector<Task> task_table(const ViewportTable& rows, int raster_width_pixels, int raster_height_pixels,
                             int display_columns) {
    std::vector<Draft> drafts = drafts_of(rows, raster_width_pixels, raster_height_pixels, display_columns);
    number_tasks(drafts);
    std::stable_sort(drafts.begin(), drafts.end(), [](const Draft& a, const Draft& b) {
        return std::pair(a.number, a.letter) < std::pair(b.number, b.letter);
    });
    std::vector<Task> tasks;
    for (const Draft& draft : drafts) {
        const bool alone = std::count_if(drafts.begin(), drafts.end(), [&](const Draft& other) {
                               return other.number == draft.number;
                           }) == 1;
        tasks.push_back(draft.task);
        tasks.back().label = std::to_string(draft.number) + (alone ? "" : letters(draft.letter));
    }
    return tasks;
}

}  // namespace metabuffer::analysis
