"""BibTeX entries of the sources of the built-in strategies, secondary terms and criteria.

Titles, journals and years are those of the derivations; authors' first names and some titles are from memory. What
could not be checked, such as pages, is left out.
"""

from __future__ import annotations

DAS_1988 = """@inproceedings{das1988,
  author = {Das, Hari and Slotine, Jean-Jacques E. and Sheridan, Thomas B.},
  title = {Inverse Kinematic Algorithms for Redundant Systems},
  booktitle = {IEEE International Conference on Robotics and Automation},
  year = {1988},
}"""

POWELL_1970 = """@incollection{powell1970,
  author = {Powell, M. J. D.},
  title = {A Hybrid Method for Nonlinear Equations},
  booktitle = {Numerical Methods for Nonlinear Algebraic Equations},
  editor = {Rabinowitz, Philip},
  year = {1970},
}"""

BARZILAI_BORWEIN_1988 = """@article{barzilai1988,
  author = {Barzilai, Jonathan and Borwein, Jonathan M.},
  title = {Two-Point Step Size Gradient Methods},
  journal = {IMA Journal of Numerical Analysis},
  volume = {8},
  year = {1988},
}"""

CHAN_DUBEY_1995 = """@article{chan1995,
  author = {Chan, Tan Fung and Dubey, Rajiv V.},
  title = {A Weighted Least-Norm Solution Based Scheme for Avoiding Joint Limits for Redundant Joint Manipulators},
  journal = {IEEE Transactions on Robotics and Automation},
  volume = {11},
  number = {2},
  year = {1995},
}"""

CHAN_LAWRENCE_1988 = """@inproceedings{chan1988,
  author = {Chan, Stephen K. and Lawrence, Peter D.},
  title = {General Inverse Kinematics with the Error Damped Pseudoinverse},
  booktitle = {IEEE International Conference on Robotics and Automation},
  year = {1988},
}"""

WAMPLER_1986 = """@article{wampler1986,
  author = {Wampler, Charles W.},
  title = {Manipulator Inverse Kinematic Solutions Based on Vector Formulations and Damped Least-Squares Methods},
  journal = {IEEE Transactions on Systems, Man, and Cybernetics},
  volume = {16},
  number = {1},
  year = {1986},
}"""

SUGIHARA_2011 = """@article{sugihara2011,
  author = {Sugihara, Tomomichi},
  title = {Solvability-Unconcerned Inverse Kinematics by the {Levenberg--Marquardt} Method},
  journal = {IEEE Transactions on Robotics},
  volume = {27},
  number = {5},
  year = {2011},
}"""

NAKAMURA_HANAFUSA_1986 = """@article{nakamura1986,
  author = {Nakamura, Yoshihiko and Hanafusa, Hideo},
  title = {Inverse Kinematic Solutions with Singularity Robustness for Robot Manipulator Control},
  journal = {Journal of Dynamic Systems, Measurement, and Control},
  volume = {108},
  number = {3},
  year = {1986},
}"""

KANOUN_2011 = """@article{kanoun2011,
  author = {Kanoun, Oussama and Lamiraux, Florent and Wieber, Pierre-Brice},
  title = {Kinematic Control of Redundant Manipulators: Generalizing the Task-Priority Framework to Inequality Tasks},
  journal = {IEEE Transactions on Robotics},
  volume = {27},
  number = {4},
  year = {2011},
}"""

ESCANDE_2014 = """@article{escande2014,
  author = {Escande, Adrien and Mansard, Nicolas and Wieber, Pierre-Brice},
  title = {Hierarchical Quadratic Programming: Fast Online Humanoid-Robot Motion Generation},
  journal = {International Journal of Robotics Research},
  volume = {33},
  number = {7},
  year = {2014},
}"""

FLACCO_2015 = """@article{flacco2015,
  author = {Flacco, Fabrizio and De Luca, Alessandro and Khatib, Oussama},
  title = {Control of Redundant Robots Under Hard Joint Constraints: Saturation in the Null Space},
  journal = {IEEE Transactions on Robotics},
  volume = {31},
  number = {3},
  year = {2015},
}"""

MINK_2024 = """@software{mink2024,
  author = {Zakka, Kevin},
  title = {mink: Python Inverse Kinematics Based on {MuJoCo}},
  url = {https://github.com/kevinzakka/mink},
  year = {2024},
}"""

PINK_2022 = """@software{pink2022,
  author = {Caron, St{\\'e}phane and others},
  title = {Pink: Python Inverse Kinematics Based on {Pinocchio}},
  url = {https://github.com/stephane-caron/pink},
  year = {2022},
}"""

GUPTASARMA_2025 = """@misc{guptasarma2025,
  author = {Guptasarma and Strong and Zhen and Kennedy},
  title = {{J-PARSE}: {Jacobian}-Based Projection Algorithm for Resolving Singularities Effectively in Inverse Kinematic
    Control of Serial Manipulators},
  eprint = {2505.00306},
  archiveprefix = {arXiv},
  year = {2025},
}"""

NOCEDAL_WRIGHT_2006 = """@book{nocedal2006,
  author = {Nocedal, Jorge and Wright, Stephen J.},
  title = {Numerical Optimization},
  edition = {2},
  publisher = {Springer},
  year = {2006},
}"""

GILL_1981 = """@book{gill1981,
  author = {Gill, Philip E. and Murray, Walter and Wright, Margaret H.},
  title = {Practical Optimization},
  publisher = {Academic Press},
  year = {1981},
}"""

SICILIANO_SLOTINE_1991 = """@inproceedings{siciliano1991,
  author = {Siciliano, Bruno and Slotine, Jean-Jacques E.},
  title = {A General Framework for Managing Multiple Tasks in Highly Redundant Robotic Systems},
  booktitle = {International Conference on Advanced Robotics},
  year = {1991},
}"""

CHIAVERINI_1997 = """@article{chiaverini1997,
  author = {Chiaverini, Stefano},
  title = {Singularity-Robust Task-Priority Redundancy Resolution for Real-Time Kinematic Control of Robot
    Manipulators},
  journal = {IEEE Transactions on Robotics and Automation},
  volume = {13},
  number = {3},
  year = {1997},
}"""

ANTONELLI_2009 = """@article{antonelli2009,
  author = {Antonelli, Gianluca},
  title = {Stability Analysis for Prioritized Closed-Loop Inverse Kinematic Algorithms for Redundant Robotic Systems},
  journal = {IEEE Transactions on Robotics},
  volume = {25},
  number = {5},
  year = {2009},
}"""

BUSS_KIM_2005 = """@article{buss2005,
  author = {Buss, Samuel R. and Kim, Jin-Su},
  title = {Selectively Damped Least Squares for Inverse Kinematics},
  journal = {Journal of Graphics Tools},
  volume = {10},
  number = {3},
  year = {2005},
}"""

YOSHIKAWA_1985 = """@article{yoshikawa1985,
  author = {Yoshikawa, Tsuneo},
  title = {Manipulability of Robotic Mechanisms},
  journal = {International Journal of Robotics Research},
  volume = {4},
  number = {2},
  year = {1985},
}"""

CHIU_1988 = """@article{chiu1988,
  author = {Chiu, Stephen L.},
  title = {Task Compatibility of Manipulator Postures},
  journal = {International Journal of Robotics Research},
  volume = {7},
  number = {5},
  year = {1988},
}"""

KHATIB_1986 = """@article{khatib1986,
  author = {Khatib, Oussama},
  title = {Real-Time Obstacle Avoidance for Manipulators and Mobile Robots},
  journal = {International Journal of Robotics Research},
  volume = {5},
  number = {1},
  year = {1986},
}"""

SALISBURY_CRAIG_1982 = """@article{salisbury1982,
  author = {Salisbury, J. Kenneth and Craig, John J.},
  title = {Articulated Hands: Force Control and Kinematic Issues},
  journal = {International Journal of Robotics Research},
  volume = {1},
  number = {1},
  year = {1982},
}"""

ANGELES_LOPEZ_CAJUN_1992 = """@article{angeles1992,
  author = {Angeles, Jorge and Lopez-Cajun, Carlos S.},
  title = {Kinematic Isotropy and the Conditioning Index of Serial Robotic Manipulators},
  journal = {International Journal of Robotics Research},
  volume = {11},
  number = {6},
  year = {1992},
}"""

KLEIN_BLAHO_1987 = """@article{klein1987,
  author = {Klein, Charles A. and Blaho, Bruce E.},
  title = {Dexterity Measures for the Design and Control of Kinematically Redundant Manipulators},
  journal = {International Journal of Robotics Research},
  volume = {6},
  number = {2},
  year = {1987},
}"""

KREUTZ_DELGADO_1992 = """@article{kreutz1992,
  author = {Kreutz-Delgado, Kenneth and Long, Mark and Seraji, Homayoun},
  title = {Kinematic Analysis of {7-DOF} Manipulators},
  journal = {International Journal of Robotics Research},
  volume = {11},
  number = {5},
  year = {1992},
}"""

LIEGEOIS_1977 = """@article{liegeois1977,
  author = {Liegeois, Alain},
  title = {Automatic Supervisory Control of the Configuration and Behavior of Multibody Mechanisms},
  journal = {IEEE Transactions on Systems, Man, and Cybernetics},
  volume = {7},
  number = {12},
  year = {1977},
}"""

WHITNEY_1969 = """@article{whitney1969,
  author = {Whitney, Daniel E.},
  title = {Resolved Motion Rate Control of Manipulators and Human Prostheses},
  journal = {IEEE Transactions on Man-Machine Systems},
  volume = {10},
  number = {2},
  year = {1969},
}"""

ZGHAL_1990 = """@inproceedings{zghal1990,
  author = {Zghal, Hassan and Dubey, Rajiv V. and Euler, James A.},
  title = {Efficient Gradient Projection Optimization for Manipulators with Multiple Degrees of Redundancy},
  booktitle = {IEEE International Conference on Robotics and Automation},
  year = {1990},
}"""

MARCHAND_1996 = """@inproceedings{marchand1996,
  author = {Marchand, {\\'E}ric and Chaumette, Fran{\\c{c}}ois and Rizzo, Alessandro},
  title = {Using the Task Function Approach to Avoid Robot Joint Limits and Kinematic Singularities in Visual Servoing},
  booktitle = {IEEE/RSJ International Conference on Intelligent Robots and Systems},
  year = {1996},
}"""

MARCHAND_HAGER_1998 = """@inproceedings{marchand1998,
  author = {Marchand, {\\'E}ric and Hager, Gregory D.},
  title = {Dynamic Sensor Planning in Visual Servoing},
  booktitle = {IEEE International Conference on Robotics and Automation},
  year = {1998},
}"""

KLEIN_1984 = """@incollection{klein1984,
  author = {Klein, Charles A.},
  title = {Use of Redundancy in the Design of Robotic Systems},
  booktitle = {Robotics Research: The Second International Symposium},
  year = {1984},
}"""

JTIK_2026 = """@software{jtik2026,
  author = {{The jtik developers}},
  title = {jtik: Redundancy-Resolving Inverse Kinematics},
  year = {2026},
}"""

LI_2020 = """@article{li2020,
  author = {Li, Minchen and Ferguson, Zachary and Schneider, Teseo and Langlois, Timothy and Zorin, Denis and
    Panozzo, Daniele and Jiang, Chenfanfu and Kaufman, Danny M.},
  title = {Incremental Potential Contact: Intersection- and Inversion-Free, Large-Deformation Dynamics},
  journal = {ACM Transactions on Graphics},
  volume = {39},
  number = {4},
  year = {2020},
}"""

KREISSELMEIER_1979 = """@inproceedings{kreisselmeier1979,
  author = {Kreisselmeier, Gerhard and Steinhauser, Reinhold},
  title = {Systematic Control Design by Optimizing a Vector Performance Index},
  booktitle = {IFAC Symposium on Computer Aided Design of Control Systems},
  year = {1979},
}"""
