#pragma once
#include <iosfwd>
#include <string>
#include <vector>

namespace mm {

/// The spindle housing of SENSORS as finite elements for CalculiX: a cast-iron block with a square bore along
/// x, two bearing seats in the bore as heat sources, convection on all outer faces, and a foot below its rear
/// half. The spindle runs 600 s, stops 300 s, runs 1200 s, stops 300 s, and runs until 2 h. SI units; x from
/// the nose to the rear, z upwards.
class Housing {
 public:
  static constexpr int kSamples = 100;
  static constexpr double kDuration = 7200.0;  // s

  /// One candidate for a sensor: 18 along x on the top, and on each side face.
  struct Candidate {
    int node;
    std::string name;  // face and distance from the front bearing over that of the two bearings: "top_0.18L"
  };

  Housing();
  const std::vector<Candidate>& candidates() const { return candidates_; }

  /// Writes the deck: mesh, material, duty, and print requests for candidates and nose.
  void writeDeck(std::ostream& deck) const;

  /// Writes where the candidates sit: sensor,x_mm,y_mm,z_mm.
  void writePositions(std::ostream& csv) const;

  /// Reads what CalculiX printed and writes the CSV of `mm sensors`: time_s, one column a candidate in degC,
  /// and nose_um, the growth of the nose towards the workpiece. Throws InputError when samples or nodes are
  /// missing, or not finite: the run stopped early or diverged.
  void convert(const std::string& results, std::ostream& csv) const;

 private:
  static constexpr int kX = 19, kY = 8;         // elements along x, and across in y and z
  static constexpr int kBore = 2;               // elements of wall beside the bore
  static constexpr int kFront = 4, kRear = 15;  // nodes along x at the middle of the bearing seats
  static int node(int i, int j, int k) { return 1 + (i * (kY + 1) + j) * (kY + 1) + k; }
  static bool inBore(int j, int k) { return j >= kBore && j < kY - kBore && k >= kBore && k < kY - kBore; }
  static bool insideBore(int j, int k) { return j > kBore && j < kY - kBore && k > kBore && k < kY - kBore; }

  void writeMesh(std::ostream& deck) const;
  void writeLoads(std::ostream& deck) const;
  std::vector<int> noseNodes() const;

  std::vector<Candidate> candidates_;
};

}  // namespace mm
