#include "datapath/slot_table.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <numeric>

namespace metabuffer {
namespace {

constexpr std::int64_t kLargestScale = std::int64_t{1} << 32;
constexpr std::int64_t kFallbackScale = std::int64_t{1} << 20;

/// A factor that makes every 1 / Dmultiple a whole number, or nearly one if the common multiple is too large.
std::int64_t weight_scale(const ViewportTable& rows) {
    std::int64_t scale = 1;
    for (const ViewportRow& row : rows) {
        scale = std::lcm(scale, std::int64_t{row.dmultiple});
        if (scale > kLargestScale) return kFallbackScale;
    }
    return scale;
}

/// What each composer needs per raster row, C_i / T_i, as whole numbers. The rows are valid: no weight is zero, and no
/// sum of them exceeds 64 bits.
std::vector<std::int64_t> weights(const ViewportTable& rows) {
    const std::int64_t scale = weight_scale(rows);
    std::vector<std::int64_t> result;
    result.reserve(rows.size());
    for (const ViewportRow& row : rows) {
        result.push_back(row.sdx * scale / row.dmultiple);
    }
    return result;
}

std::int64_t sum_of(const std::vector<std::int64_t>& values) {
    return std::accumulate(values.begin(), values.end(), std::int64_t{0});
}

/// The shortest table in exact proportion, or, if that is too long, one of about as many slots as the limit.
std::vector<std::int64_t> slot_counts(std::vector<std::int64_t> counts, std::int64_t limit) {
    std::int64_t divisor = counts.front();
    for (const std::int64_t count : counts) divisor = std::gcd(divisor, count);
    for (std::int64_t& count : counts) count /= divisor;

    const std::int64_t sum = sum_of(counts);
    if (sum <= std::max<std::int64_t>(limit, 1)) return counts;
    for (std::int64_t& count : counts) {
        const std::int64_t rounded = (2 * count * limit + sum) / (2 * sum);
        count = std::max<std::int64_t>(1, rounded);
    }
    return counts;
}

/// Smooth weighted round robin: in every slot each composer earns its share of credit. The richest gets the slot and
/// pays the sum of all shares. So its slots lie as evenly as the others allow.
std::vector<int> spread(const std::vector<std::int64_t>& counts) {
    const std::int64_t total = sum_of(counts);
    std::vector<std::int64_t> credits(counts.size(), 0);
    std::vector<int> table;
    table.reserve(static_cast<std::size_t>(total));
    for (std::int64_t slot = 0; slot < total; ++slot) {
        for (std::size_t i = 0; i < counts.size(); ++i) credits[i] += counts[i];
        const auto richest = std::max_element(credits.begin(), credits.end());
        *richest -= total;
        table.push_back(static_cast<int>(richest - credits.begin()));
    }
    return table;
}

}  // namespace

std::vector<int> slot_table(const ViewportTable& rows, int limit_slots) {
    if (rows.empty()) return {};
    return spread(slot_counts(weights(rows), limit_slots));
}

std::vector<int> equal_slot_table(const ViewportTable& rows, int /*limit_slots*/) {
    std::vector<int> table(rows.size());
    std::iota(table.begin(), table.end(), 0);
    return table;
}

std::vector<int> sent_indices(const ValidatedTable& table) {
    std::vector<int> indices;
    auto dropped = table.rejected.begin();
    for (int index = 0; indices.size() < table.rows.size(); ++index) {
        if (dropped != table.rejected.end() && dropped->index == index) {
            ++dropped;
        } else {
            indices.push_back(index);
        }
    }
    return indices;
}

std::optional<std::vector<int>> judge_slots(const std::vector<int>& indices, const ValidatedTable& table) {
    const std::size_t sent = table.rows.size() + table.rejected.size();
    if (indices.size() > static_cast<std::size_t>(most_slots(static_cast<int>(sent)))) return std::nullopt;
    constexpr int kDropped = -1;
    std::vector<int> row_of(sent, kDropped);
    int standing = 0;
    for (const int index : sent_indices(table)) row_of[static_cast<std::size_t>(index)] = standing++;
    std::vector<bool> has_slot(table.rows.size(), false);
    std::vector<int> slots;
    slots.reserve(indices.size());
    for (const int index : indices) {
        const int row =
            static_cast<std::size_t>(index) < sent ? row_of[static_cast<std::size_t>(index)] : kDropped;
        if (row == kDropped) return std::nullopt;
        has_slot[static_cast<std::size_t>(row)] = true;
        slots.push_back(row);
    }
    if (std::find(has_slot.begin(), has_slot.end(), false) != has_slot.end()) return std::nullopt;
    return slots;
}

}  // namespace metabuffer
