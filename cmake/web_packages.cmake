# The packages of the npm registry that the pages use: name@version, and for each file of it its place in the package, the
# name it gets in the build's folder web, and its sha256. Those that the pages use are MIT, installed with their licences; axe-core (MPL 2.0) judges the
# accessibility of the pages in the tests and is not installed.
set(web_packages plotly preact uplot three)
set(web_test_packages axe)
set(plotly_package "plotly.js-dist-min@4.1.2")
set(plotly_files
    plotly.min.js plotly.min.js 2f645d1bade8182fce161b7f10f89402f8b315805250ff4a94672a28d23c390a
    LICENSE plotly.LICENSE 8c45d9eaf50c2f72dd9c7ab9ef440788ba58a3538484b5c51c1f17d5128752e7)
set(preact_package "preact@11.2.0")
set(preact_files
    dist/preact.mjs preact.mjs bdcbd9abdf2c77c5c45326eab42191e949222d479d0d5f69467387a77040cb55
    hooks/dist/hooks.mjs hooks.mjs e862ab2973aa6455eaa0f77c5d832d2157d6be59a17c8ba546550a575b58c6b4
    LICENSE preact.LICENSE 1fe6958409c8c257a70c587a18b6f7f412b179b456630790d30b2ec9a8e4b7d4)
set(uplot_package "uplot@1.6.32")
set(uplot_files
    dist/uPlot.esm.js uPlot.mjs 5dd9b3281aa64b461b42d9945f6adb2649d346502b12281a9ae0d46599a80eba
    dist/uPlot.min.css uPlot.min.css df630c6a8d6f8eeaff264b50f73ce5b114f646ffd9a0bb74f049b0a00135fa04
    LICENSE uplot.LICENSE 8f989229699b4fe2f1a0432d0e9edc338a8a911e250e2d1b01ecd770a5f5b1bd)
set(three_package "three@0.187.0")
set(three_files
    build/three.module.js three.module.js 104f56145899722094556490d787aae0617cc2fc3382f31df02d724ea1aee341
    build/three.core.js three.core.js 613e370f76638fdef83926642bf256dc9615684922de1ce1f63a8583e5d78578
    examples/jsm/loaders/STLLoader.js STLLoader.js a07441b8cd812faf8049741fe5e95373b19547e4038694753dfec26fe230a7eb
    examples/jsm/loaders/OBJLoader.js OBJLoader.js 355484026ac163fdeceececaa943b0473a2e169444015cd2209cc7d27b5b894d
    examples/jsm/loaders/collada/ColladaParser.js ColladaParser.js d9532ab17f1d9e2919deba8029d759d5dcaed2f21195ded9e29491f719b1a0c6
    examples/jsm/loaders/collada/ColladaComposer.js ColladaComposer.js eb262d262790a59d3e3b3c50abc56d565f6d97a34a3979151321da73ab9846a1
    LICENSE three.LICENSE 8b378ebe60e2fe500158cb0ac71cb5e8b7d92953c2abcc63a0eb90499653b5bc)
set(axe_package "axe-core@4.14.1")
set(axe_files
    axe.min.js axe.min.js 29348999450cdf2849a8e70b7912fc2da85a849da39c0d0d5394f51d4a9ed95c)
