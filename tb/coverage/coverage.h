#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <map>
#include <set>
#include <string>

namespace metabuffer::coverage {

/// A group of goals: things of one kind that must each have happened in a test before the testbench is trusted.
struct GroupTitle {
    const char* name;     ///< "bus/burst"
    const char* meaning;  ///< one line for the report
};

/// A goal and how often it has been reached.
struct Goal {
    std::string name;  ///< in its group
    std::int64_t count = 0;
};

/// All goals, group by group. The cover groups of the code that hits them declare them (cover_group.h).
class Coverage {
  public:
    struct Group {
        std::string meaning;
        std::deque<Goal> goals;  ///< in the order of their declaration; each stays where it is
    };

    Coverage() = default;
    Coverage(const Coverage&) = delete;  // bins refer to its goals
    Coverage& operator=(const Coverage&) = delete;

    /// Several declarations may add to one group. Throws std::logic_error for a goal that is there already, and for a
    /// group that has another meaning there.
    Goal& declare(const GroupTitle& group, const std::string& name);

    const std::map<std::string, Group>& groups() const { return groups_; }  ///< by name
    std::size_t goal_count() const { return full_names_.size(); }
    /// full_name: "GROUP: GOAL", as full_name() puts it together.
    bool has_goal(const std::string& full_name) const { return full_names_.count(full_name) != 0; }

  private:
    std::map<std::string, Group> groups_;
    std::set<std::string> full_names_;
};

/// Stands between the names of group and goal. No group's name holds it.
constexpr const char* kBehindGroup = ": ";

inline std::string full_name(const std::string& group, const std::string& goal) {
    return group + kBehindGroup + goal;
}

}  // namespace metabuffer::coverage
