// What is wrong with a job file, and where.
#pragma once

#include <string>
#include <vector>

namespace creep {

/// A place in a text: lines and columns count from 1, columns in code points.
struct TextPosition {
  int line = 1;
  int column = 1;
};

/// One error or warning about a job file.
struct Diagnostic {
  int line = 1;
  int column = 1;
  std::string message;
};

/// Collects everything that is wrong, so that one look shows all of it.
struct DiagnosticLog {
  std::vector<Diagnostic> errors;
  std::vector<Diagnostic> warnings;

  void error(TextPosition at, std::string message) {
    errors.push_back({at.line, at.column, std::move(message)});
  }
  void warning(TextPosition at, std::string message) {
    warnings.push_back({at.line, at.column, std::move(message)});
  }
};

}  // namespace creep
