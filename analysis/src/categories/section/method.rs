//! Methods and sources that matching and same/different have in common.

use crate::maths::bootstrap::REPLICATES;

/// How accuracies and intervals by observer are computed.
pub(super) fn observers_method() -> String {
    format!(
        "Intervals of accuracy are those of Clopper and Pearson (1934) and Wilson (1927), which take answers \
         for independent; the cluster-robust one (Liang and Zeger 1986; on the logit scale, with Student's t) \
         and the bootstrap ({REPLICATES} studies of resampled observers; expanded percentiles, Hesterberg \
         2015) allow for observers who differ. Whether they do is tested by χ² (Cochran 1954) and by dealing \
         out the right answers anew."
    )
}

pub(super) const TIMES_METHOD: &str = "Response times are summarised by medians with intervals between order statistics (Conover 1999), which \
     assume no form of distribution, and compared within observers by Wilcoxon's (1945) signed-rank test, \
     exact, corrected by Holm (1979). Outliers are beyond Tukey's (1977) outer fences; nothing is left out. \
     No answer to a stimulus comes within 0.2 s of its beginning (Luce 1986).";

pub(super) const REFERENCES: [&str; 18] = [
    "Clopper, C. J. and Pearson, E. S. (1934). The use of confidence or fiducial limits illustrated in the \
     case of the binomial. Biometrika 26, 404–413.",
    "Cochran, W. G. (1954). Some methods for strengthening the common χ² tests. Biometrics 10, 417–451.",
    "Cohen, J. (1960). A coefficient of agreement for nominal scales. Educational and Psychological \
     Measurement 20, 37–46.",
    "Conover, W. J. (1999). Practical Nonparametric Statistics, 3rd edition. Wiley, New York.",
    "Fleiss, J. L., Cohen, J. and Everitt, B. S. (1969). Large sample standard errors of kappa and weighted \
     kappa. Psychological Bulletin 72, 323–327.",
    "Hautus, M. J. (1995). Corrections for extreme proportions and their biasing effects on estimated values \
     of d′. Behavior Research Methods, Instruments, & Computers 27, 46–51.",
    "Hesterberg, T. C. (2015). What teachers should know about the bootstrap. The American Statistician 69, \
     371–386.",
    "Holm, S. (1979). A simple sequentially rejective multiple test procedure. Scandinavian Journal of \
     Statistics 6, 65–70.",
    "Kaplan, H. L., Macmillan, N. A. and Creelman, C. D. (1978). Tables of d′ for variable-standard \
     discrimination paradigms. Behavior Research Methods & Instrumentation 10, 796–813.",
    "Liang, K.-Y. and Zeger, S. L. (1986). Longitudinal data analysis using generalized linear models. \
     Biometrika 73, 13–22.",
    "Luce, R. D. (1986). Response Times: Their Role in Inferring Elementary Mental Organization. Oxford \
     University Press, New York.",
    "Macmillan, N. A. and Creelman, C. D. (2005). Detection Theory: A User's Guide, 2nd edition. Lawrence \
     Erlbaum Associates, Mahwah.",
    "Miller, G. A. (1955). Note on the bias of information estimates. In Quastler, H. (ed.), Information \
     Theory in Psychology, 95–100. Free Press, Glencoe.",
    "Tukey, J. W. (1977). Exploratory Data Analysis. Addison-Wesley, Reading.",
    "Venzon, D. J. and Moolgavkar, S. H. (1988). A method for computing profile-likelihood-based confidence \
     intervals. Applied Statistics 37, 87–94.",
    "Wald, A. and Wolfowitz, J. (1940). On a test whether two samples are from the same population. The \
     Annals of Mathematical Statistics 11, 147–162.",
    "Wilcoxon, F. (1945). Individual comparisons by ranking methods. Biometrics Bulletin 1, 80–83.",
    "Wilson, E. B. (1927). Probable inference, the law of succession, and statistical inference. Journal of \
     the American Statistical Association 22, 209–212.",
];
