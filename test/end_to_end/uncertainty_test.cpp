// `mm uncertainty` and `mm certificate` as they are typed.
#include "calibration_file/calibration_yaml.h"
#include "session_folder.h"

namespace mm {
namespace {

using UncertaintyOfTasks = SessionFolder;

TEST_F(UncertaintyOfTasks, IsPrintedAndRepeatsWithItsSeed) {
  const Answer answer = typed("uncertainty c.yaml --task distance:-10,0,0:10,0,0 --trials 20000 --json");
  ASSERT_EQ(answer.status, 0) << answer.error;
  const nlohmann::json json = answer.json();
  EXPECT_NEAR(json["mean_mm"].get<double>(), 20.0, 1e-3);
  EXPECT_GT(json["std_um"].get<double>(), 0.0);
  double sum = 0.0;
  for (const auto& share : json["budget"]) sum += share["share"].get<double>();
  EXPECT_NEAR(sum, 1.0, 1e-9);
  EXPECT_EQ(typed("uncertainty c.yaml --task distance:-10,0,0:10,0,0 --trials 20000 --threads 1 --json").out,
            answer.out);
  const Answer text = typed("uncertainty c.yaml --task distance:-10,0,0:10,0,0 --trials 1000");
  EXPECT_NE(text.out.find("U = "), std::string::npos) << text.out;
  EXPECT_NE(text.out.find("Variance by cause"), std::string::npos) << text.out;
}

TEST_F(UncertaintyOfTasks, OutsideTheVolumeAndNotConformingIsANo) {
  const Answer outside = typed("uncertainty c.yaml --task distance:-10,0,0:1000,0,0 --trials 1000 --json");
  EXPECT_EQ(outside.status, 1);
  EXPECT_NE(outside.error.find("does not hold at (1000, 0, 0) mm: x = "), std::string::npos) << outside.error;
  EXPECT_FALSE(outside.json()["valid"].get<bool>());
  const std::string task =
      "uncertainty c.yaml --task distance:-10,0,0:10,0,0 --trials 1000 --tolerance-um 100 ";
  EXPECT_EQ(typed(task).status, 0);
  EXPECT_EQ(typed(task + "--measured-mm 20.05").status, 0);
  const Answer wrong = typed(task + "--measured-mm 20.5 --json");
  EXPECT_EQ(wrong.status, 1);
  EXPECT_EQ(wrong.json()["decisions"][0]["verdict"], "does_not_conform");
}

TEST_F(UncertaintyOfTasks, BadInputIsOneLine) {
  const std::string task = "uncertainty c.yaml --task ";
  expectRefused(task + "distance:0,0,0:0,0,0", {"length is zero", "distance:x,y,z:x,y,z"});
  expectRefused(task + "distnace:0,0,0:1,0,0", {"distnace", "did you mean 'distance'"});
  expectRefused(task + "distance:0,0,nan:1,0,0", {"'nan'"});
  expectRefused("uncertainty c.yaml", {"--task"});
  expectRefused("uncertainty none.yaml --task position:0,0,0", {"none.yaml"});
  const std::string position = task + "position:0,0,0 ";
  expectRefused(position + "--temperature bed", {"'bed'", "bed=21.5"});
  expectRefused(position + "--temperature bed=warm", {"'warm'"});
  expectRefused(position + "--temperature bed=21", {"'bed'", "not a sensor"});
  expectRefused(position + "--direction x=2", {"'2'", "+1"});
  expectRefused(position + "--direction w=1", {"'w'", "x, y, z"});
  expectRefused(position + "--approach 0,0,0", {"not a direction"});
  expectRefused(position + "--quantity diameter", {"'diameter'", "x, y, z"});
  expectRefused(position + "--mpe 1,100", {"--mpe"});
  expectRefused(position + "--mpe 1", {"'1'", "needs 2"});
  expectRefused(position + "--measured-mm 1", {"--tolerance-um"});
  expectRefused(position + "--trials 1", {"--trials", "'1'"});
  expectRefused(position + "--tolerance-um nan", {"--tolerance-um", "'nan'"});
}

using Certificates = SessionFolder;

TEST_F(Certificates, ArePagesThatACheckAcceptsAndARefusalProtects) {
  const Answer made = typed(
      "certificate c.yaml s.bag -o cert.html --operator 'E. Abbe' --serial M-17 --task "
      "distance:-10,0,0:10,0,0 "
      "--trials 2000 --tolerance-um 100 --artifact-scale-um-m 1 --authorised-by 'C. Zeiss' --interval-s 60");
  ASSERT_EQ(made.status, 0) << made.error;
  const std::string page = textOf(*folder_ / "cert.html");
  for (const char* part :
       {"E. Abbe", "M-17", "those of the calibration itself", "ISO 230-2", "predicted to keep the limit",
        "Authorised by: C. Zeiss", "60 s, stated by the issuer; usual: 5 s"})
    EXPECT_NE(page.find(part), std::string::npos) << part;
  const Answer checked = typed("certificate --check cert.html");
  EXPECT_EQ(checked.status, 0) << checked.error;
  const std::string digest = checked.out.substr(checked.out.find("SHA-256"));
  EXPECT_NE(made.out.find(digest), std::string::npos) << made.out;
  EXPECT_EQ(typed("certificate c.yaml --check cert.html").status, 0);
  expectRefused("certificate t.yaml --check cert.html", {"is of calibration"});
  // The session and the file by which it was made, where they are at hand.
  const Answer both = typed("certificate c.yaml s.bag --check cert.html");
  EXPECT_EQ(both.status, 0) << both.error;
  EXPECT_NE(both.out.find("the one that was certified, CRC-64 "), std::string::npos) << both.out;
  EXPECT_NE(both.out.find("the one by which it was calibrated, hash "), std::string::npos) << both.out;
  EXPECT_NE(typed("certificate --check cert.html --store none").out.find("calibration file: not available"),
            std::string::npos);
  const Calibration certified = loadCalibration(*folder_ / "c.yaml");
  std::filesystem::create_directory(*folder_ / "kept");
  std::filesystem::copy_file(*folder_ / "c.yaml", *folder_ / ("kept/" + certified.id + ".yaml"));
  const Answer kept = typed("certificate --check cert.html --store kept");
  EXPECT_EQ(kept.status, 0) << kept.error;
  EXPECT_NE(kept.out.find("CRC-64 "), std::string::npos) << kept.out;
  // The same id with another number in it.
  Calibration changed = certified;
  changed.values.front().value *= 1.001;
  saveCalibration(changed, *folder_ / "changed.yaml");
  expectRefused("certificate changed.yaml --check cert.html", {"issued for the file with CRC-64", "changed"});
  std::filesystem::remove_all(*folder_ / "kept");
  std::filesystem::remove(*folder_ / "changed.yaml");
  std::string tampered = page;
  tampered.replace(tampered.find("M-17"), 4, "M-18");
  folder_->write("tampered.html", tampered);
  expectRefused("certificate --check tampered.html", {"tampered.html", "does not match its checksum"});
  expectRefused("certificate --check s.csv", {"s.csv", "no seal"});
  expectRefused("certificate c.yaml -o cert.txt", {"cert.txt", ".pdf, .html or .xml"});
  expectRefused("certificate c.yaml -o cert.pdf --sign key.pem", {"--sign", "ends in .xml"});
  expectRefused("certificate c.yaml s.bag -o s.bag", {"s.bag", "name another file"});
  expectRefused("certificate c.yaml --force -o c.yaml", {"c.yaml", "name another file"});
  expectRefused("certificate c.yaml -o plan.yaml", {"plan.yaml", "a measurement plan"});
  expectRefused("certificate c.yaml", {"-o"});
  expectRefused("certificate -o cert.pdf", {"calibration"});
  std::filesystem::remove(*folder_ / "cert.html");
  std::filesystem::remove(*folder_ / "tampered.html");
}

// The instrument's uncertainty is not stated: there are results, and no conformity.
TEST_F(Certificates, StateNoConformityWithoutTheUncertaintyOfTheReference) {
  const Answer made = typed(
      "certificate c.yaml -o results.html --task distance:-10,0,0:10,0,0 --trials 200 --tolerance-um 100");
  EXPECT_EQ(made.status, 1);
  EXPECT_NE(made.error.find("no statement of conformity: "), std::string::npos) << made.error;
  EXPECT_NE(made.error.find("--artifact-scale-um-m"), std::string::npos) << made.error;
  const std::string page = textOf(*folder_ / "results.html");
  EXPECT_NE(page.find("No statement of conformity"), std::string::npos);
  EXPECT_EQ(page.find("predicted to keep the limit"), std::string::npos);
  std::filesystem::remove(*folder_ / "results.html");
}

/// The line of what was printed that follows this text.
std::string wordAfter(const std::string& text, const std::string& before) {
  const std::size_t at = text.find(before);
  return at == std::string::npos ? std::string()
                                 : text.substr(at + before.size(), text.find('\n', at) - at - before.size());
}

TEST_F(Certificates, EveryIssueHasItsNumberAndSaysWhatItReplaces) {
  const std::string task = " --task position:0,0,0 --trials 200",
                    id = "certificate id: ", old = "replaces the one of id: ";
  const Answer first = typed("certificate c.yaml -o a.html" + task),
               again = typed("certificate c.yaml -o a.html" + task);
  ASSERT_EQ(again.status, 0) << again.error;
  EXPECT_EQ(wordAfter(first.out, old), "");
  EXPECT_EQ(wordAfter(again.out, old), wordAfter(first.out, id));
  EXPECT_NE(wordAfter(again.out, id), wordAfter(first.out, id));
  EXPECT_NE(textOf(*folder_ / "a.html").find("certificate No. " + wordAfter(first.out, id)),
            std::string::npos);
  EXPECT_EQ(wordAfter(typed("certificate --check a.html").out, id), wordAfter(again.out, id));
  // A certificate of another calibration in its place is no issue of this one.
  EXPECT_EQ(wordAfter(typed("certificate t.yaml -o a.html" + task).out, old), "");
  // In a store issues are counted, whatever the files are called; one in another file replaces none.
  run("promote c.yaml --store counted");
  const std::string store = task + " --store counted";
  const Answer one = typed("certificate c.yaml -o b.html" + store),
               two = typed("certificate c.yaml -o d.html" + store),
               xml = typed("certificate c.yaml -o d.xml" + store);
  EXPECT_EQ(wordAfter(one.out, id).back(), '1') << one.out;
  EXPECT_EQ(wordAfter(two.out, id).back(), '2') << two.out;
  EXPECT_EQ(wordAfter(two.out, old) + wordAfter(xml.out, old), "");
  EXPECT_EQ(wordAfter(xml.out, id).back(), '3') << xml.out;
  for (const char* file : {"a.html", "b.html", "d.html", "d.xml"}) std::filesystem::remove(*folder_ / file);
  std::filesystem::remove_all(*folder_ / "counted");
}

TEST_F(Certificates, AreSignedAsXmlAndRefusedWhenChanged) {
  const auto shell = [&](const std::string& command) {
    return WEXITSTATUS(
        std::system(("cd '" + *folder_ / "." + "' && " + command + " >/dev/null 2>&1").c_str()));
  };
  for (const char* key : {"lab", "other"}) {
    const std::string name = key;
    ASSERT_EQ(shell("openssl ecparam -name prime256v1 -genkey -noout -out " + name +
                    ".pem && openssl pkey -in " + name + ".pem -pubout -out " + name + "_public.pem"),
              0);
  }
  const std::string task = " --task position:0,0,0 --trials 200 --operator 'E. Abbe'";
  run("certificate c.yaml s.bag -o signed.xml --sign lab.pem" + task);
  const std::string xml = textOf(*folder_ / "signed.xml");
  EXPECT_EQ(xml.find("PRIVATE"), std::string::npos);
  const std::string grammar = std::filesystem::absolute("test/data/dcc/dcc.rng").string();
  EXPECT_EQ(shell("xmllint --noout --relaxng '" + grammar + "' signed.xml"), 0);
  // Any program that verifies XML signatures agrees.
  EXPECT_EQ(shell("xmlsec1 --verify --enabled-key-data key-name --pubkey-pem:\"$(sed "
                  "'s/.*<ds:KeyName>//;s/<.*//' signed.xml | grep -m 1 '^[0-9a-f]\\{64\\}$')\" "
                  "lab_public.pem signed.xml"),
            0);
  const Answer valid = typed("certificate --check signed.xml");
  EXPECT_EQ(valid.status, 0) << valid.error;
  EXPECT_NE(valid.out.find("signature valid"), std::string::npos) << valid.out;
  EXPECT_NE(valid.out.find("only the issuer can say"), std::string::npos) << valid.out;
  const Answer known = typed("certificate c.yaml s.bag --check signed.xml --key lab_public.pem");
  EXPECT_EQ(known.status, 0) << known.error;
  EXPECT_NE(known.out.find("the one that was certified, CRC-64 "), std::string::npos) << known.out;
  expectRefused("certificate --check signed.xml --key other_public.pem",
                {"is not signed with other_public.pem"});
  expectRefused("certificate t.yaml --check signed.xml", {"is of calibration"});
  // Changed: a word, a figure, the signature itself; taken off; signed by somebody else under the same name.
  const auto changed = [&](const std::string& from, const std::string& to) {
    std::string text = xml;
    const std::size_t at = text.find(from);
    EXPECT_NE(at, std::string::npos) << from;
    folder_->write("changed.xml", text.replace(at, from.size(), to));
  };
  for (const auto& [from, to] : {std::pair<const char*, const char*>{"E. Abbe", "E. Abbf"},
                                 {"<si:coverageFactor>2", "<si:coverageFactor>3"},
                                 {"<ds:SignatureValue>", "<ds:SignatureValue>A"}}) {
    changed(from, to);
    expectRefused("certificate --check changed.xml", {"changed.xml", "was changed after it was signed"});
  }
  // A seal of paper, which everybody can append, is none of XML.
  std::string sealed = xml;
  sealed.replace(sealed.find("E. Abbe"), 7, "E. Abbf");
  folder_->write("changed.xml", sealed +
                                    "<!-- mm-certificate: calibration 20260301T093000Z-00c0ffee sha256 " +
                                    std::string(64, '0') + " -->\n");
  expectRefused("certificate --check changed.xml", {"changed.xml", "was changed after it was signed"});
  folder_->write("changed.xml",
                 xml.substr(0, xml.find("<ds:Signature ")) + "</dcc:digitalCalibrationCertificate>\n");
  expectRefused("certificate --check changed.xml", {"says that it is signed, but has no signature"});
  run("certificate c.yaml -o unsigned.xml" + task);
  const Answer open = typed("certificate --check unsigned.xml");
  EXPECT_EQ(open.status, 1);
  EXPECT_NE(open.out.find("not signed"), std::string::npos) << open.out;
  EXPECT_EQ(open.out.find("valid"), std::string::npos) << open.out;

  expectRefused("certificate c.yaml -o new.xml --sign lab_public.pem" + task,
                {"lab_public.pem", "no private key"});
  expectRefused("certificate c.yaml -o new.xml --sign none.pem" + task, {"none.pem"});
  expectRefused("certificate c.yaml -o new.xml --key lab.pem" + task, {"--key", "--sign"});
  ASSERT_EQ(shell("openssl pkey -in lab.pem -aes256 -passout pass:secret -out locked.pem"), 0);
  expectRefused("certificate c.yaml -o new.xml --sign locked.pem" + task, {"locked.pem", "encrypted"});
  // Without the program that signs.
  const std::string empty = *folder_ / "no_signer";
  std::filesystem::create_directory(empty);
  const std::string out = *folder_ / "stderr.txt";
  const int status = std::system(
      ("cd '" + *folder_ / "." + "' && PATH='" + empty +
       "' '" MM_PROGRAM "' certificate c.yaml -o new.xml --sign lab.pem >/dev/null 2>'" + out + "'")
          .c_str());
  EXPECT_EQ(WEXITSTATUS(status), 2);
  EXPECT_NE(textOf(out).find("apt install xmlsec1"), std::string::npos) << textOf(out);
  EXPECT_FALSE(std::filesystem::exists(*folder_ / "new.xml"));
  std::filesystem::remove(empty);
  for (const char* file : {"signed.xml", "changed.xml", "unsigned.xml", "lab.pem", "lab_public.pem",
                           "other.pem", "other_public.pem", "locked.pem"})
    std::filesystem::remove(*folder_ / file);
}

TEST_F(Certificates, WithoutAPrinterThereIsNoPdfAndAClearWord) {
  const std::string empty = *folder_ / "no_programs";
  std::filesystem::create_directory(empty);
  const std::string out = *folder_ / "stderr.txt";
  const int status = std::system(
      ("cd '" + *folder_ / "." + "' && PATH='" + empty +
       "' '" MM_PROGRAM "' certificate c.yaml -o cert.pdf --trials 100 >/dev/null 2>'" + out + "'")
          .c_str());
  EXPECT_EQ(WEXITSTATUS(status), 2);
  EXPECT_NE(textOf(out).find("apt install weasyprint"), std::string::npos) << textOf(out);
  EXPECT_FALSE(std::filesystem::exists(*folder_ / "cert.pdf"));
  std::filesystem::remove(empty);
}

// A stand-in for WeasyPrint: what it prints is sealed as a PDF, and one that prints nothing is refused.
TEST_F(Certificates, AreSealedAsPdf) {
  const auto printer = [&](const std::string& script) {
    const std::string file = folder_->write("weasyprint", "#!/bin/sh\n" + script + "\n");
    std::filesystem::permissions(file, std::filesystem::perms::owner_all);
  };
  const std::string task = "certificate c.yaml -o cert.pdf --task position:0,0,0 --trials 200";
  const auto printed = [&](const std::string& command) {
    const std::string error = *folder_ / "stderr.txt";
    const int status = std::system(("cd '" + *folder_ / "." + "' && PATH=.:$PATH '" MM_PROGRAM "' " +
                                    command + " >/dev/null 2>'" + error + "'")
                                       .c_str());
    return Answer{WEXITSTATUS(status), {}, textOf(error)};
  };
  printer("grep -q '<h1>Record of calibration' \"$2\" && printf '%%PDF-1.4\\n%%%%EOF\\n' >\"$3\"");
  const Answer made = printed(task);
  EXPECT_EQ(made.status, 0) << made.error;
  EXPECT_EQ(textOf(*folder_ / "cert.pdf").substr(0, 5), "%PDF-");
  EXPECT_EQ(typed("certificate --check cert.pdf").status, 0);
  EXPECT_EQ(printed(task).status, 0) << "a certificate may replace a certificate";
  printer("true");
  const std::string other = "certificate c.yaml -o other.pdf --task position:0,0,0 --trials 200";
  const Answer nothing = printed(other);
  EXPECT_EQ(nothing.status, 2);
  EXPECT_NE(nothing.error.find("printed nothing"), std::string::npos) << nothing.error;
  printer("echo '%PDF-1.4'; exit 3");
  const Answer half = printed(other);
  EXPECT_EQ(half.status, 2);
  EXPECT_NE(half.error.find("failed to print"), std::string::npos) << half.error;
  EXPECT_FALSE(std::filesystem::exists(*folder_ / "other.pdf"));
  // What was not printed was not issued: the next is no. 1, and replaces none.
  run("promote c.yaml --store listed");
  EXPECT_EQ(printed(other + " --store listed").status, 2);
  const Answer first =
      typed("certificate c.yaml -o first.html --task position:0,0,0 --trials 200 --store listed");
  EXPECT_EQ(wordAfter(first.out, "certificate id: ").back(), '1') << first.out;
  EXPECT_EQ(wordAfter(first.out, "replaces the one of id: "), "");
  std::filesystem::remove_all(*folder_ / "listed");
  for (const char* file : {"cert.pdf", "first.html", "weasyprint"}) std::filesystem::remove(*folder_ / file);
}

}  // namespace
}  // namespace mm
