#include <fstream>
#include <iostream>
#include <string>
#include <vector>

#include "base/error.h"
#include "housing.h"

namespace {

int usage() {
  std::cerr << "spindle_housing deck housing.inp              writes the deck for CalculiX\n"
               "spindle_housing positions out.csv             where the candidates sit\n"
               "spindle_housing convert housing.dat out.csv   its results to the series of mm sensors\n";
  return 2;
}

void require(const std::ios& file, const std::string& path) {
  if (!file) throw mm::InputError(path + ": cannot be opened or written; check path and disk");
}

}  // namespace

int main(int argc, char** argv) {
  const std::vector<std::string> words(argv + 1, argv + argc);
  try {
    const mm::Housing housing;
    if (words.size() == 2 && words[0] == "deck") {
      std::ofstream deck(words[1]);
      require(deck, words[1]);
      housing.writeDeck(deck);
      require(deck.flush(), words[1]);
      return 0;
    }
    if (words.size() == 2 && words[0] == "positions") {
      std::ofstream csv(words[1]);
      require(csv, words[1]);
      housing.writePositions(csv);
      require(csv.flush(), words[1]);
      return 0;
    }
    if (words.size() == 3 && words[0] == "convert") {
      std::ofstream csv(words[2]);
      require(csv, words[2]);
      housing.convert(words[1], csv);
      require(csv.flush(), words[2]);
      return 0;
    }
    return usage();
  } catch (const mm::Error& e) {
    std::cerr << "spindle_housing: error: " << e.what() << std::endl;
    return 2;
  }
}
