/// A parameter table as commented .ini text: the effective configuration, and what `loopline describe --ini`
/// prints.
#pragma once

#include <string>

#include "api/parameters.h"

namespace loopline {

/// `text` as lines of comment, wrapped.
std::string ini_comment(const std::string& text);

/// `[section]` and every key with its present value, under a comment with its sentence, unit, range and
/// default.
std::string ini_section_text(const ParameterTable& table);

/// "unit m, 0 .. 1, default 0.02": what there is of it.
std::string parameter_facts(const Parameter& parameter);

/// "number", "whole number", "one of", ...
std::string kind_text(ParameterKind kind);

}  // namespace loopline
