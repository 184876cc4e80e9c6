// What `mm` says of itself, how it is stopped, and the commands that begin a machine's life.
#include <fcntl.h>
#include <sys/stat.h>

#include <map>
#include <thread>

#include "session_folder.h"

namespace mm {
namespace {

class CommandLine : public SessionFolder {
 protected:
  /// The name of the plan with so many contacts of each ball, instead of 75.
  static std::string points(int count) {
    std::string plan = textOf(*folder_ / "plan.yaml");
    plan.replace(plan.find("points: 75"), 10, "points: " + std::to_string(count));
    folder_->write("points.yaml", plan);
    return "points.yaml";
  }
};

std::vector<std::string> linesOf(const std::string& text) {
  std::vector<std::string> lines;
  std::istringstream in(text);
  for (std::string line; std::getline(in, line);) lines.push_back(line);
  return lines;
}

TEST_F(CommandLine, TheVersionIsThatOfThePackage) {
  const std::string package = textOf("package.xml");
  const std::size_t from = package.find("<version>") + 9;
  const std::string version = package.substr(from, package.find("</version>") - from);
  EXPECT_EQ(typed("--version").out, "mm " + version + "\n");
  EXPECT_NE(textOf(*folder_ / "c.yaml").find("software: " + version + "\n"), std::string::npos);
}

TEST_F(CommandLine, EveryHelpTellsTheExitStatuses) {
  const std::vector<std::string> commands = linesOf(typed("manual --list").out);
  EXPECT_GE(commands.size(), 20u);
  for (const std::string& command : commands) {
    const Answer help = typed(command + " --help");
    EXPECT_EQ(help.status, 0) << command;
    for (const char* words : {"0 done", "1 the answer is no", "2 bad input", "130 stopped by Ctrl-C"})
      EXPECT_NE(help.out.find(words), std::string::npos) << command << ": " << words;
  }
  EXPECT_NE(typed("--help").out.find("130 stopped by Ctrl-C"), std::string::npos);
}

TEST_F(CommandLine, BoundsStandInTheHelp) {
  EXPECT_NE(typed("apply --help").out.find("[0 to 10]"), std::string::npos);
  EXPECT_NE(typed("calibrate --help").out.find("[2 to 10000000]"), std::string::npos);
}

TEST_F(CommandLine, CtrlCKeepsTheBestOfACalibration) {
  const Answer answer =
      stoppedWhen(workedFor(1.5), *folder_,
                  "calibrate s.bag --model m.yaml -o stopped.yaml --generations 10000000 --stages "
                  "10000000:1");
  EXPECT_EQ(answer.status, 130) << answer.error;
  EXPECT_NE(answer.error.find("best result so far"), std::string::npos) << answer.error;
  EXPECT_EQ(typed("compare s.bag --calibration stopped.yaml").status, 0);
}

TEST_F(CommandLine, CtrlCEndsABenchmarkWithWhatItCounted) {
  const Answer answer =
      stoppedWhen(workedFor(1.0 * std::thread::hardware_concurrency()), *folder_,
                  "mm-benchmark --plan plan.yaml --trials 100000 --only backlash --contacts 20 --json");
  EXPECT_EQ(answer.status, 130) << answer.error;
  EXPECT_EQ(linesOf(answer.error).size(), 1u) << answer.error;
  ASSERT_FALSE(answer.out.empty());
  EXPECT_GE(answer.json()["trials"].size(), 1u);
}

TEST_F(CommandLine, CtrlCDuringADiagnosisLosesNothing) {
  // so long that it is stopped in its middle
  run("simulate --machine three_axis --plan " + points(600) + " --hide backlash:x=3um -o plate.bag");
  folder_->write("none.yaml", "machine: three_axis\neffects: []\n");
  run("calibrate plate.bag --model none.yaml --method least_squares -o plate.yaml");
  const auto before = files();
  const Answer answer =
      stoppedWhen(workedFor(1.0), *folder_, "diagnose plate.bag --calibration plate.yaml --moves moves.yaml");
  EXPECT_EQ(answer.status, 130) << answer.error;
  EXPECT_EQ(linesOf(answer.error).size(), 1u) << answer.error;
  EXPECT_NE(answer.error.find("nothing was written"), std::string::npos) << answer.error;
  EXPECT_EQ(files(), before);
}

TEST_F(CommandLine, CtrlCEndsAReadThatWaits) {
  const std::string fifo = *folder_ / "fifo";
  ASSERT_EQ(::mkfifo(fifo.c_str(), 0600), 0);
  const int writer = ::open(fifo.c_str(), O_RDWR | O_CLOEXEC);  // that never writes
  // of some, Ctrl-C comes between opening the pipe and waiting for it
  for (int turn = 0; turn < 6 && !HasFailure(); ++turn)
    for (const char* reader : {"apply fifo --calibration c.yaml -o waiting.csv",
                               "import fifo --machine three_axis -o waiting.bag"}) {
      const Answer waiting = stoppedWhen(opened(fifo), *folder_, reader);
      EXPECT_EQ(waiting.status, 130) << waiting.error;
    }
  for (const char* file : {"waiting.csv", "waiting.bag"})
    EXPECT_FALSE(std::filesystem::exists(*folder_ / file));
  ::close(writer);
  std::filesystem::remove(fifo);
}

TEST_F(CommandLine, AddAllGoesTheWholeWay) {
  run("simulate --machine three_axis --plan " + points(8) + " --hide backlash:x=3um --seed 5 -o way.bag");
  folder_->write("none.yaml", "machine: three_axis\neffects: []\n");
  run("calibrate way.bag --model none.yaml --method least_squares -o way.yaml");
  const Answer answer = typed("add way.bag --calibration way.yaml --all -o way_end.yaml --json");
  ASSERT_EQ(answer.status, 0) << answer.error;
  const nlohmann::json ledger = answer.json()["ledger"];
  ASSERT_GE(ledger.size(), 2u);
  EXPECT_EQ(ledger[0]["action"], "calibrate");
  EXPECT_EQ(ledger[1]["action"], "add");
  EXPECT_EQ(ledger[1]["effect"], (nlohmann::json{{"type", "backlash"}, {"axis", "x"}}));
  EXPECT_LT(ledger.back()["rms_um"][1].get<double>(), 0.4);
  EXPECT_NE(answer.error.find("Nothing is missing"), std::string::npos) << answer.error;
  EXPECT_NE(textOf(*folder_ / "way_end.yaml").find("backlash"), std::string::npos);
  // at the end of the way there is nothing to add, and that is no error
  const Answer again = typed("add way.bag --calibration way_end.yaml --all -o way_again.yaml");
  EXPECT_EQ(again.status, 0) << again.error;
  EXPECT_NE(again.out.find("nothing was added"), std::string::npos) << again.out;
}

TEST_F(CommandLine, ANewMachineItsPlanAndItsFirstModelCalibrate) {
  run("machine new --axis x=0:120mm@-1,0,0 --axis y=0:100mm --axis z=-60:0mm --tip-mm 0,0,-40 -o mill.urdf "
      "--model "
      "mill.yaml");
  run("plan new --machine mill.urdf --balls 3x3 --points 20 --repeatability-um 0.5 -o mill_plan.yaml");
  run("simulate --machine mill.urdf --plan mill_plan.yaml --hide scale:y=100ppm -o mill.bag");
  const Answer answer =
      typed("calibrate mill.bag --model mill.yaml --method least_squares -o mill_c.yaml --json");
  ASSERT_EQ(answer.status, 0) << answer.error;
  EXPECT_EQ(answer.json()["observations"], 180);
  EXPECT_EQ(answer.json()["identifiability"]["rank"], 6);
}

TEST_F(CommandLine, ANewMachineOfRotaryAxesHasAModelThatIsRead) {
  const Answer made = typed(
      "machine new --axis pan=-90:90deg@0,0,1 --axis tilt=0:90deg@0,1,0 --tip-mm 100,0,0 -o head.urdf "
      "--model head.yaml");
  EXPECT_NE(made.out.find(": w-b-C-B-t\n"), std::string::npos) << made.out << made.error;
  EXPECT_EQ(textOf(*folder_ / "head.yaml"), "machine: head.urdf\neffects: []\n");
  folder_->write("head.csv", "time_s,pan_deg,deviation_pan_arcsec\n0,0,1\n1,10,2\n2,20,3\n3,30,5\n");
  run("import head.csv --machine head.urdf -o head.bag");
  EXPECT_EQ(typed("check head.bag --model head.yaml").status, 0);
}

TEST_F(CommandLine, ALeadOfAScrewIsThePeriodThatTheFirstModelFits) {
  run("machine new --axis x=0:120mm --axis y=0:100mm --axis z=-60:0mm --lead x=12mm -o screw.urdf --model "
      "screw.yaml");
  EXPECT_NE(textOf(*folder_ / "screw.yaml").find("{type: lead_screw_periodic, axis: x, period_mm: 12}"),
            std::string::npos);
  run("plan new --machine screw.urdf --balls 3x3 --points 20 --repeatability-um 0.5 -o screw_plan.yaml");
  run("simulate --machine screw.urdf --plan screw_plan.yaml --hide scale:y=100ppm -o screw.bag");
  const Answer answer =
      typed("calibrate screw.bag --model screw.yaml --method least_squares -o screw_c.yaml --json");
  ASSERT_EQ(answer.status, 0) << answer.error;
  EXPECT_EQ(answer.json()["identifiability"]["rank"], 8);  // three scales, three squarenesses, S and K
}

// No repeatability is stated anywhere: the plan's own repeats tell it, and the end of the loop is an answer.
TEST_F(CommandLine, ANewMachineWithANewPlanIsExplained) {
  run("machine new --axis x=0:120mm --axis y=0:100mm --axis z=-60:0mm --tip-mm 0,0,-40 -o own.urdf --model "
      "own.yaml");
  run("plan new --machine own.urdf --balls 2x2 --points 12 -o own_plan.yaml");
  run("simulate --machine own.urdf --plan own_plan.yaml --hide backlash:y=4um -o own.bag");
  run("calibrate own.bag --model own.yaml --method least_squares -o own_c.yaml");
  const Answer answer = typed("add own.bag --calibration own_c.yaml --all -o own_end.yaml");
  EXPECT_EQ(answer.status, 0) << answer.error;
  EXPECT_NE(answer.error.find("Nothing is missing"), std::string::npos) << answer.error;
  EXPECT_NE(answer.error.find("repeated measurements"), std::string::npos) << answer.error;
  run("plan verify own_plan.yaml --calibration own_end.yaml -o own_verify.yaml");  // repeats and all
}

TEST_F(CommandLine, ANewPlanForAnInstrumentStaysWithinTheTravels) {
  run("plan new --machine three_axis --positions 7 --runs 2 -o axes.yaml");
  run("simulate --machine three_axis --plan axes.yaml -o axes.bag");
  const Answer answer = typed("check axes.bag --json");
  ASSERT_EQ(answer.status, 0) << answer.error;
  EXPECT_EQ(answer.json()["references"], 3 * 7 * 2 * 2);
  expectRefused("plan new --machine three_axis --positions 9 -o axes.yaml", {"axes.yaml", "--force"});
}

TEST_F(CommandLine, EveryTestOfAStandardIsPlannedAndSimulated) {
  const std::map<std::string, int> references = {{"positioning", 550}, {"etve", 289},      {"spindle", 61},
                                                 {"linear", 549},      {"rotary", 122},    {"circular", 219},
                                                 {"rotation", 300},    {"diagonal", 1100}, {"length", 210}};
  for (const auto& [test, count] : references) {
    run("plan new --machine five_axis --test " + test + " -o " + test + ".yaml");
    run("simulate --machine five_axis --plan " + test + ".yaml -o " + test + ".bag");
    const Answer answer = typed("check " + test + ".bag --json");
    EXPECT_EQ(answer.status, 0) << test << ": " << answer.error;
    EXPECT_EQ(answer.json()["references"], count) << test;
  }
}

TEST_F(CommandLine, ANewPlanTakesAnArtifact) {
  run("plan new --machine three_axis --artifact artifact.yaml --points 12 -o one.yaml");
  run("simulate --machine three_axis --plan one.yaml -o one.bag");
  EXPECT_EQ(typed("check one.bag --json").json()["contacts"], 12 + 2 * 12) << "and 12 targets twice";
}

TEST_F(CommandLine, TheCatalogueComesFromTheRegistry) {
  const nlohmann::json all = typed("effects --json").json()["effects"];
  EXPECT_GE(all.size(), 33u);
  const nlohmann::json one = typed("effects straightness --json").json()["effects"];
  ASSERT_EQ(one.size(), 1u);
  EXPECT_EQ(one[0]["iso230"], "EXY") << "of " << one[0]["example"];
  EXPECT_EQ(one[0]["keys"][2]["key"], "degree");
  EXPECT_EQ(one[0]["keys"][2]["lower"], 2.0);
  EXPECT_EQ(one[0]["parameters"][0]["unit"], "um");
  EXPECT_FALSE(one[0]["cause"].get<std::string>().empty());
  EXPECT_FALSE(one[0]["remedy"].get<std::string>().empty());
  EXPECT_NE(typed("effects thermal_growth").out.find("a temperature sensor"), std::string::npos);
}

TEST_F(CommandLine, BashCompletesCommandsOptionsAndWords) {
  const auto complete = [&](const std::string& words, int at) {
    const std::string script = folder_->write(
        "complete.sh", "source <('" MM_PROGRAM "' completion bash)\nCOMP_WORDS=(" + words +
                           ")\nCOMP_CWORD=" + std::to_string(at) + "\n_mm\necho \"${COMPREPLY[@]}\"\n");
    const std::string out = *folder_ / "completed.txt";
    EXPECT_EQ(std::system(("bash '" + script + "' >'" + out + "'").c_str()), 0);
    return textOf(out);
  };
  EXPECT_EQ(complete("mm cal", 1), "calibrate\n");
  EXPECT_EQ(complete("mm calibrate --mod", 2), "--model\n");
  EXPECT_EQ(complete("mm sensors s.csv --estimator h", 4), "histogram\n");
  EXPECT_EQ(complete("mm machine n", 2), "new\n");
  EXPECT_EQ(complete("mm machine new --ti", 3), "--tip-mm\n");
  EXPECT_EQ(complete("mm completion z", 2), "zsh\n");
  EXPECT_EQ(complete("mm effects backl", 2), "backlash\n");
  EXPECT_EQ(complete("mm calibrate s.bag --method leas", 4), "least_squares\n");
  EXPECT_EQ(complete("mm import s.csv --machine three", 4), "three_axis\n");
  EXPECT_EQ(complete("mm export c.yaml --to linux", 4), "linuxcnc\n");
}

TEST_F(CommandLine, BashCompletesFilesOfTheKindThatIsTaken) {
  const std::string place = *folder_ / "typed";
  std::filesystem::create_directories(place);
  for (const char* name : {"a session.bag", "a.yaml", "a.urdf", "a.csv"})
    folder_->write(std::string("typed/") + name, "");
  const auto complete = [&](const std::string& words, int at) {
    const std::string script = folder_->write(
        "complete.sh", "cd '" + place + "'\nsource <('" MM_PROGRAM "' completion bash)\nCOMP_WORDS=(" +
                           words + ")\nCOMP_CWORD=" + std::to_string(at) +
                           "\n_mm\nprintf '%s\\n' \"${COMPREPLY[@]}\"\n");
    const std::string out = *folder_ / "completed.txt";
    EXPECT_EQ(std::system(("bash '" + script + "' >'" + out + "'").c_str()), 0);
    return textOf(out);
  };
  EXPECT_EQ(complete("mm check a", 2), "a session.bag\n");
  EXPECT_EQ(complete("mm check s.bag --model a", 4), "a.yaml\n");
  EXPECT_EQ(complete("mm simulate --machine a", 3), "a.urdf\n");
  EXPECT_EQ(complete("mm calibrate s.bag -o a", 4), "\n") << "any file, which the shell completes itself";
  std::filesystem::remove_all(place);
}

TEST_F(CommandLine, TheZshScriptNamesEveryCommandAndOption) {
  const std::string script = typed("completion zsh").out;
  EXPECT_EQ(script.rfind("#compdef mm\n", 0), 0u);
  for (const std::string& command : linesOf(typed("manual --list").out))
    EXPECT_NE(script.find("    '" + command + "')\n"), std::string::npos) << command;
  for (const char* option : {"*--calibration[", "*--estimator[", ":(ksg histogram correlation)'"})
    EXPECT_NE(script.find(option), std::string::npos) << option;
}

TEST_F(CommandLine, EveryCommandHasAManualPage) {
  for (std::string command : linesOf(typed("manual --list").out)) {
    const Answer page = typed("manual " + command);
    EXPECT_EQ(page.status, 0) << command;
    std::replace(command.begin(), command.end(), ' ', '-');
    EXPECT_NE(page.out.find("mm\\-"), std::string::npos) << command;
    for (const char* part : {".TH ", ".SH NAME", ".SH SYNOPSIS", ".SH OPTIONS", "130 stopped by Ctrl"})
      EXPECT_NE(page.out.find(part), std::string::npos) << command << ": " << part;
    for (const std::string& line : linesOf(page.out))  // a line that begins with a dot is a request
      if (!line.empty() && line[0] == '.') {
        EXPECT_TRUE(std::isupper(line[1]) != 0 || line == ".nf" || line == ".fi") << line;
      }
  }
  EXPECT_NE(typed("manual").out.find("mm\\-calibrate"), std::string::npos);
}

/// The keys and units of the catalogue of effects are those of --hide, too.
TEST_F(CommandLine, HideSpeaksAsTheCatalogue) {
  const std::string plan =
      " --plan " + std::filesystem::absolute("config/plans/nine_ball_plate.yaml").string();
  const Answer slope = typed("simulate --machine three_axis" + plan +
                             " --hide squareness:y/x=80um/m --hide lead_screw_periodic:x=2um,period_mm=2 "
                             "--truth hidden.yaml -o hidden.bag");
  EXPECT_EQ(slope.status, 0) << slope.error;
  const std::string truth = textOf(*folder_ / "hidden.yaml");
  EXPECT_NE(truth.find("type: squareness, axis: y, of: x, c: 16.5"), std::string::npos) << truth;  // arcsec
  EXPECT_NE(truth.find("period: 2000 um"), std::string::npos) << truth;
}

/// What a controller's files say is what the simulated one does, on a rotary joint too: its degrees are not
/// rad.
TEST_F(CommandLine, ASimulatedControllerCorrectsByItsFiles) {
  folder_->write("rotary.yaml",
                 "reference: [{joint: b, from_deg: -60, to_deg: 60, points: 7, runs: 4, dwell_s: 5}]\n"
                 "instrument: {noise: {reference_arcsec: 0.2}}\n");
  std::filesystem::create_directory(*folder_ / "loaded");
  folder_->write("loaded/settings.txt", "$23=0\n$164=0.01\n");  // backlash of b: 0.01 deg = 36 arcsec
  const auto scatter = [](const std::string& compensation) {
    run("simulate --machine five_axis --plan rotary.yaml --hide backlash:b=36arcsec --compensation " +
        compensation + " --csv rotary.csv --force -o rotary.bag");
    const auto lines = linesOf(textOf(*folder_ / "rotary.csv"));
    const auto column = [](const std::string& line, const std::string& name, const std::string& header) {
      std::istringstream names(header), cells(line);
      for (std::string n, cell; std::getline(names, n, ',') && std::getline(cells, cell, ',');)
        if (n == name) return cell;
      return std::string();
    };
    std::vector<double> deviations;  // arcsec
    for (std::size_t i = 1; i < lines.size(); ++i)
      if (const std::string cell = column(lines[i], "deviation_b_arcsec", lines[0]); !cell.empty())
        deviations.push_back(std::stod(cell));
    double mean = 0.0, square = 0.0;
    for (const double d : deviations) mean += d / static_cast<double>(deviations.size());
    for (const double d : deviations)
      square += (d - mean) * (d - mean) / static_cast<double>(deviations.size());
    EXPECT_EQ(deviations.size(), 56u);  // seven targets, from both sides, four times
    return std::sqrt(square);
  };
  EXPECT_NEAR(scatter("none"), 18.0, 0.1);
  EXPECT_NEAR(scatter("grblhal:loaded"), 0.2, 0.06);  // of the instrument, known to 10 %
}

/// As many parameters as readings fit whatever was measured: the answer is no, and the file is written.
TEST_F(CommandLine, AFitWithoutRedundancyIsNoAnswer) {
  folder_->write("exact.csv", "time_s,x_mm,deviation_x_um\n0,1,3\n");
  run("import exact.csv --machine three_axis -o exact.bag");
  const Answer answer = typed("calibrate exact.bag --model m.yaml --method least_squares -o exact.yaml");
  EXPECT_EQ(answer.status, 1) << answer.error;
  EXPECT_NE(answer.error.find("degrees of freedom 0"), std::string::npos) << answer.error;
  EXPECT_NE(answer.out.find("Repeatability  not known"), std::string::npos) << answer.out;
  EXPECT_TRUE(std::filesystem::exists(*folder_ / "exact.yaml"));
}

/// 300 um at a scatter of micrometres is a mistaken unit: everybody who judges by it says so.
TEST_F(CommandLine, ARepeatabilityFarAboveTheScatterIsDoubted) {
  run("calibrate s.bag --model m.yaml --method least_squares -o doubted.yaml");
  const std::string fit = " --repeatability-um 300";
  for (const std::string& command : {"calibrate s.bag --model m.yaml --method least_squares" + fit,
                                     "compare s.bag --calibration doubted.yaml" + fit,
                                     "diagnose s.bag --calibration doubted.yaml" + fit}) {
    const Answer answer = typed(command);
    EXPECT_NE(answer.status, 2) << command << answer.error;
    EXPECT_NE(answer.error.find("the declared repeatability of 300 um is"), std::string::npos)
        << command << answer.error;
    EXPECT_NE(answer.error.find("times the scatter of the residuals ("), std::string::npos) << answer.error;
  }
  const Answer plain = typed("compare s.bag --calibration doubted.yaml");
  EXPECT_EQ(plain.error.find("repeatability of"), std::string::npos) << plain.error;
}

/// A genetic search is no use where least squares has one minimum, and the result says so.
TEST_F(CommandLine, ALinearModelNeedsNoSearch) {
  const Answer searched = typed("calibrate s.bag --model m.yaml --generations 3 --population 20");
  EXPECT_NE(searched.out.find("every parameter is linear: --method least_squares"), std::string::npos)
      << searched.out;
  const Answer direct = typed("calibrate s.bag --model m.yaml --method least_squares");
  EXPECT_NE(direct.out.find("  least squares   from the start values of the model, no search\n"),
            std::string::npos)
      << direct.out;
  EXPECT_EQ(direct.out.find("every parameter is linear"), std::string::npos) << direct.out;
}

/// What check says cannot be shown, diagnose does not find.
TEST_F(CommandLine, CheckAndDiagnoseAgreeOnTheRadiusOfTheProbe) {
  run("simulate --machine three_axis --plan " + points(20) +
      " --hide probe_radius=4um --seed 6 -o radius.bag");
  const nlohmann::json check = typed("check radius.bag --json").json();
  for (const nlohmann::json& hidden : check["cannot_show"])
    EXPECT_NE(hidden["effect"]["type"], "probe_radius") << hidden;
  folder_->write("bare.yaml", "machine: three_axis\neffects: []\n");
  run("calibrate radius.bag --model bare.yaml --method least_squares -o radius.yaml");
  const nlohmann::json found = typed("diagnose radius.bag --calibration radius.yaml --json").json();
  ASSERT_EQ(found["missing"].size(), 1u);
  EXPECT_EQ(found["missing"][0]["effect"]["type"], "probe_radius");
}

/// A calibration ends with what to type next, and its uncertainties say of which kind they are.
TEST_F(CommandLine, ACalibrationSaysWhatToTypeNext) {
  const Answer answer = typed("calibrate s.bag --model m.yaml --method least_squares -o next.yaml");
  EXPECT_NE(answer.out.find("mm diagnose s.bag --calibration next.yaml says"), std::string::npos)
      << answer.out;
  EXPECT_NE(answer.out.find("± is the expanded uncertainty, k = 2\n"), std::string::npos) << answer.out;
}

}  // namespace
}  // namespace mm
