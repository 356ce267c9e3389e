#pragma once

#include <array>
#include <cstddef>

namespace metabuffer {

/// Whether row i of a table is that of enumerator i, counted from 0; each row has its enumerator as `value`.
template <typename Row, std::size_t kCount>
constexpr bool is_in_order(const std::array<Row, kCount>& table) {
    for (std::size_t i = 0; i < kCount; ++i) {
        if (static_cast<std::size_t>(table[i].value) != i) return false;
    }
    return true;
}

/// An enumerator's row of a table that is in order. Throws std::out_of_range for a value that has none.
template <typename Row, std::size_t kCount, typename Enum>
constexpr const Row& row_of(const std::array<Row, kCount>& table, Enum value) {
    return table.at(static_cast<std::size_t>(value));
}

}  // namespace metabuffer
